#include "arbox/drawing/internal/font.h"

asm(".section .rodata\n"
    ".balign 16\n"
    "arbox_font_regular_begin: .incbin \"" ARBOX_FONT_REGULAR
    "\"\n"
    "arbox_font_regular_end: .byte 0\n"
    ".balign 16\n"
    "arbox_font_bold_begin: .incbin \"" ARBOX_FONT_BOLD
    "\"\n"
    "arbox_font_bold_end: .byte 0\n"
    ".text\n");

namespace arbox::drawing {

extern const unsigned char regular_begin[] asm("arbox_font_regular_begin")
    __attribute__((visibility("hidden")));
extern const unsigned char regular_end[] asm("arbox_font_regular_end")
    __attribute__((visibility("hidden")));
extern const unsigned char bold_begin[] asm("arbox_font_bold_begin")
    __attribute__((visibility("hidden")));
extern const unsigned char bold_end[] asm("arbox_font_bold_end")
    __attribute__((visibility("hidden")));

FontData font_data(bool bold) {
  return bold ? FontData{bold_begin, bold_end} : FontData{regular_begin, regular_end};
}

}  // namespace arbox::drawing
