#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "arbox/base/error.h"
#include "arbox/drawing/internal/font.h"

namespace arbox::drawing {
namespace {

constexpr double kFixed = 64.0;

struct Faces {
  FT_Library library = nullptr;
  std::array<FT_Face, 2> face = {};

  Faces() {
    if (FT_Init_FreeType(&library) != 0) throw NotAvailable("drawing: FreeType does not start");
    for (const bool bold : {false, true}) {
      const FontData data = font_data(bold);
      if (FT_New_Memory_Face(library, data.begin, data.end - data.begin, 0, &face[bold]) != 0) {
        throw NotAvailable("drawing: FreeType cannot read the compiled-in font");
      }
    }
  }
  ~Faces() { FT_Done_FreeType(library); }
  Faces(const Faces&) = delete;
  Faces& operator=(const Faces&) = delete;
};

// FreeType's objects may not be shared between threads.
FT_Face sized_face(double size, bool bold) {
  thread_local Faces faces;
  const FT_Face face = faces.face[bold];
  FT_Set_Char_Size(face, static_cast<FT_F26Dot6>(std::lround(size * kFixed)), 0, 72, 72);
  return face;
}

// An ill-formed byte stands for itself, so that any string can be drawn.
char32_t next_character(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 1;
  if (length == 1 || length > text.size()) {
    text.remove_prefix(1);
    return first;
  }
  char32_t code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0u) != 0x80u) {
      text.remove_prefix(1);
      return first;
    }
    code = (code << 6) | (next & 0x3Fu);
  }
  text.remove_prefix(length);
  return code;
}

// Calls visit(face) with each glyph's outline loaded and the pen's way so far, in 1/64 pixel.
template <class Visit>
FT_Pos walk(FT_Face face, std::string_view text, const Visit& visit) {
  FT_Pos pen = 0;
  FT_UInt previous = 0;
  while (!text.empty()) {
    const FT_UInt glyph = FT_Get_Char_Index(face, next_character(text));
    FT_Vector kerning = {0, 0};
    FT_Get_Kerning(face, previous, glyph, FT_KERNING_UNFITTED, &kerning);
    pen += kerning.x;
    if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) == 0) {
      visit(pen);
      pen += face->glyph->linearHoriAdvance >> 10;
    }
    previous = glyph;
  }
  return pen;
}

void merge(TextMask& into, const FT_GlyphSlot slot) {
  const FT_Bitmap& bitmap = slot->bitmap;
  for (unsigned y = 0; y < bitmap.rows; ++y) {
    const int row = static_cast<int>(y) - slot->bitmap_top - into.top;
    if (row < 0 || row >= into.height) continue;
    for (unsigned x = 0; x < bitmap.width; ++x) {
      const int column = static_cast<int>(x) + slot->bitmap_left - into.left;
      if (column < 0 || column >= into.width) continue;
      std::uint8_t& cell = into.coverage[static_cast<std::size_t>(row) * into.width + column];
      cell = std::max(cell, bitmap.buffer[y * bitmap.pitch + x]);
    }
  }
}

}  // namespace

double text_width(std::string_view text, double size, bool bold) {
  return walk(sized_face(size, bold), text, [](FT_Pos) {}) / kFixed;
}

TextMask render_text(std::string_view text, double size, bool bold, bool upward, double fraction_x,
                     double fraction_y) {
  const int along = static_cast<int>(std::ceil(text_width(text, size, bold) + 2.0 * size));
  const int across = static_cast<int>(std::ceil(2.5 * size)) + 2;
  const int before = static_cast<int>(std::ceil(size));
  const int above = static_cast<int>(std::ceil(1.5 * size));
  TextMask mask;
  mask.width = upward ? across : along;
  mask.height = upward ? along : across;
  mask.left = upward ? -above : -before;
  mask.top = upward ? before - along : -above;
  mask.coverage.assign(static_cast<std::size_t>(mask.width) * mask.height, 0);
  const FT_Face face = sized_face(size, bold);
  const auto start_x = static_cast<FT_Pos>(std::lround(fraction_x * kFixed));
  const auto start_y = static_cast<FT_Pos>(std::lround(-fraction_y * kFixed));
  walk(face, text, [&](FT_Pos pen) {
    FT_Outline& outline = face->glyph->outline;
    if (upward) {
      const FT_Matrix quarter_turn = {0, -0x10000, 0x10000, 0};
      FT_Outline_Transform(&outline, &quarter_turn);
    }
    FT_Outline_Translate(&outline, start_x + (upward ? 0 : pen), start_y + (upward ? pen : 0));
    if (FT_Render_Glyph(face->glyph, FT_RENDER_MODE_NORMAL) == 0) merge(mask, face->glyph);
  });
  return mask;
}

}  // namespace arbox::drawing
