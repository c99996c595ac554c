#pragma once

#include "arbox/drawing/scene.h"

namespace arbox::cli {

/// Opens a window with the scene until it is closed: PCL's viewer, in a library of its own
/// (libarbox_program_viewer.so) that alone links VTK and is opened here. Keys: n and b step through
/// the quantiles, k shows the samples, h lists the viewer's own.
///
/// Throws UsageError if there is no display, NotAvailable if this installation has no viewer.
void view_interactively(const drawing::Scene& scene, const drawing::SceneOptions& options);

/// The one function of the library, `arbox_view_interactively`: false if no display can be opened.
using ViewInteractively = bool(const drawing::Scene& scene, const drawing::SceneOptions& options);

}  // namespace arbox::cli
