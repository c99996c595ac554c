#pragma once

#include <string>

namespace arbox {

/// The kernels with which OpenBLAS, that of LibTorch's matrix products, works in this process, by
/// its own name ("SkylakeX", "Haswell", "Zen"); empty when no OpenBLAS is loaded.
std::string blas_kernels();

/// Gives OpenBLAS kernels for this CPU where it has wrongly chosen those of a Pentium 4.
///
/// OpenBLAS before 0.3.25 (Debian 12 has 0.3.21, Ubuntu 22.04 has 0.3.20) does so on every Intel
/// CPU that is newer than itself (OpenMathLib/OpenBLAS issue 4267); training of heads then takes
/// more than twice as long (docs/training.md). The program calls this first. Call it in the `main`
/// of a program of your own, which must be linked with LibTorch or OpenCV, or have loaded them:
/// never while another thread uses BLAS or the environment.
///
/// Gives true if kernels were changed. Does nothing and gives false if OpenBLAS is not loaded, if
/// it has chosen other kernels, if it is a build for one CPU only, if the environment variable
/// OPENBLAS_CORETYPE tells it what to choose, or if the CPU has no AVX2. Costs microseconds.
bool mend_blas_kernels();

}  // namespace arbox
