#include "arbox/geometry/internal/point_kernels.h"

// Compiled once for each instruction set (arbox_simd_sources).
namespace arbox::geometry::internal::ARBOX_SIMD {
namespace {

#if defined(__AVX512F__)
constexpr std::size_t kLanes = 8;
#elif defined(__AVX2__)
constexpr std::size_t kLanes = 4;
#else
constexpr std::size_t kLanes = 2;
#endif
constexpr std::size_t kBlock = 4;
static_assert(kPointPadding % (kLanes * kBlock) == 0);

typedef double Vector __attribute__((vector_size(8 * kLanes)));
typedef double Unaligned __attribute__((vector_size(8 * kLanes), aligned(8)));

inline Vector load(const double* from) { return *reinterpret_cast<const Unaligned*>(from); }

inline Vector lower(Vector a, Vector b) { return a < b ? a : b; }
inline Vector higher(Vector a, Vector b) { return a > b ? a : b; }

inline Vector dot(const double* row, Vector x, Vector y, Vector z) {
  return row[0] * x + row[1] * y + row[2] * z;
}

void occupancy(const double* x, const double* y, const double* z, std::size_t count,
               const KernelBox* boxes, std::size_t box_count, double* weight) {
  const Vector zero = {};
  for (std::size_t i = 0; i < count; i += kLanes * kBlock) {
    Vector px[kBlock], py[kBlock], pz[kBlock], sum[kBlock];
    for (std::size_t j = 0; j < kBlock; ++j) {
      px[j] = load(x + i + j * kLanes);
      py[j] = load(y + i + j * kLanes);
      pz[j] = load(z + i + j * kLanes);
      sum[j] = zero;
    }
    for (std::size_t b = 0; b < box_count; ++b) {
      const KernelBox& box = boxes[b];
      for (std::size_t j = 0; j < kBlock; ++j) {
        const Vector u = dot(box.axes, px[j], py[j], pz[j]) - box.offset[0];
        const Vector v = dot(box.axes + 3, px[j], py[j], pz[j]) - box.offset[1];
        const Vector w = dot(box.axes + 6, px[j], py[j], pz[j]) - box.offset[2];
        const auto inside = (higher(u, -u) <= box.half[0]) & (higher(v, -v) <= box.half[1]) &
                            (higher(w, -w) <= box.half[2]);
        sum[j] += inside ? zero + box.weight : zero;
      }
    }
    for (std::size_t j = 0; j < kBlock; ++j) {
      *reinterpret_cast<Unaligned*>(weight + i + j * kLanes) = sum[j];
    }
  }
}

void extents(const double* x, const double* y, const double* z, std::size_t count,
             const double* rotations, std::size_t rotation_count, double* extents) {
  const Vector zero = {};
  for (std::size_t r = 0; r < rotation_count; ++r) {
    const double* rotation = rotations + 9 * r;
    double* extent = extents + 6 * r;
    Vector low[3], high[3];
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = zero + extent[a];
      high[a] = zero + extent[3 + a];
    }
    for (std::size_t i = 0; i < count; i += kLanes) {
      const Vector px = load(x + i), py = load(y + i), pz = load(z + i);
      for (std::size_t a = 0; a < 3; ++a) {
        const Vector along = dot(rotation + 3 * a, px, py, pz);
        low[a] = lower(along, low[a]);
        high[a] = higher(along, high[a]);
      }
    }
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (low[a][lane] < extent[a]) extent[a] = low[a][lane];
        if (high[a][lane] > extent[3 + a]) extent[3 + a] = high[a][lane];
      }
    }
  }
}

}  // namespace

extern const PointKernels kPointKernels;
const PointKernels kPointKernels = {occupancy, extents};

}  // namespace arbox::geometry::internal::ARBOX_SIMD
