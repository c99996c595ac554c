#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace arbox::drawing {

/// The two compiled-in font files.
struct FontData {
  const unsigned char* begin;
  const unsigned char* end;
};
FontData font_data(bool bold);

/// Coverage of a run of text in a rectangle whose top left corner is (left, top) relative to the
/// pen's start on the base line, y down.
struct TextMask {
  int left = 0, top = 0, width = 0, height = 0;
  std::vector<std::uint8_t> coverage;
};

/// Width of a run of UTF-8 text, pixels.
double text_width(std::string_view text, double size, bool bold);

/// The run of text with the pen at (fraction_x, fraction_y) of a pixel; `upward` turns it a quarter
/// counter-clockwise. Unknown characters show the font's replacement box.
TextMask render_text(std::string_view text, double size, bool bold, bool upward, double fraction_x,
                     double fraction_y);

}  // namespace arbox::drawing
