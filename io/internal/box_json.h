#pragma once

#include "arbox/geometry/box.h"
#include "arbox/io/json.h"

namespace arbox::io::internal {

/// The box of an object as format_box_json writes it; what parse_box_json refuses is refused.
geometry::Box read_box(const JsonCursor& value);

/// {"center": [...], "size": [...], "rotation": [...], "yaw": angle}. Throws InvalidArgument.
Json box_json(const geometry::Box& box);

}  // namespace arbox::io::internal
