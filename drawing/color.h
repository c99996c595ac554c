#pragma once

#include <cstdint>
#include <string_view>

/// \file
/// Colours of the pictures: a palette that colour-blind readers can tell apart and colour maps
/// whose steps look equal.

namespace arbox::drawing {

/// An sRGB colour, 8 bits a channel.
struct Color {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Color&, const Color&) = default;
};

/// Mixes two colours in the Oklab space, where equal steps look equal (Ottosson, 2020).
/// t = 0 gives `from`, t = 1 gives `to`; t is clamped to [0, 1].
Color mix(Color from, Color to, double t);

/// Colour i >= 0 of the palette of Okabe and Ito (2008), which colour-blind readers can tell apart;
/// it repeats after seven.
Color palette_color(int i);

/// The colour of an object class: fixed for the classes of the common data sets (Car, Pedestrian,
/// bed, chair, ...), so that those that stand together differ, otherwise a palette colour that
/// depends on the name alone.
Color class_color(std::string_view name);

/// A colour map with lightness linear in t (clamped to [0, 1]; NaN gives t = 0) and cool hues, so
/// that boxes in palette colours stand out from it. It runs from pale to dark on a light
/// background and from dim to bright on a dark one.
Color map_color(double t, bool dark_background);

}  // namespace arbox::drawing
