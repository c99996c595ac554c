#include "arbox/simulation/ray_tracer.h"

#include <embree3/rtcore.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "arbox/base/error.h"

namespace arbox::simulation {
namespace {

struct DeviceDeleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using TracedScene = std::unique_ptr<RTCSceneTy, SceneDeleter>;
using Prototype = std::shared_ptr<RTCSceneTy>;

RTCDevice shared_device() {
  static const Device device(rtcNewDevice("threads=1,set_affinity=0"));
  if (!device) throw NotAvailable("RayTracer: Embree gave no device");
  return device.get();
}

TracedScene build_prototype(const TriangleMesh& mesh) {
  RTCDevice device = shared_device();
  TracedScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) vertices[3 * i + axis] = mesh.vertices[i][axis];
  }
  auto* triangles = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      triangles[3 * i + corner] = mesh.triangles[i][corner];
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

void set_pose(RTCGeometry instance, unsigned step, const Eigen::Affine3d& pose) {
  const Eigen::Matrix<float, 3, 4> columns = pose.matrix().topRows<3>().cast<float>();
  rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
}

RTCRay ray_of(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
              double nearest, double farthest) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(nearest);
  ray.tfar = static_cast<float>(farthest);
  ray.time = static_cast<float>(time);
  ray.mask = ~0u;
  return ray;
}

/// Meshes that instances of several scenes share are built once, and kept as long as they live.
class PrototypeCache {
 public:
  Prototype find(const std::shared_ptr<const TriangleMesh>& mesh) {
    {
      const std::lock_guard lock(mutex_);
      const auto place = entries_.find(mesh.get());
      if (place != entries_.end() && !place->second.mesh.expired()) return place->second.built;
    }
    Prototype built(build_prototype(*mesh).release(), SceneDeleter());
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [](const auto& entry) { return entry.second.mesh.expired(); });
    entries_.insert_or_assign(mesh.get(), Entry{mesh, built});
    return built;
  }

 private:
  struct Entry {
    std::weak_ptr<const TriangleMesh> mesh;
    Prototype built;
  };
  std::mutex mutex_;
  std::map<const TriangleMesh*, Entry> entries_;
};

PrototypeCache& prototype_cache() {
  static PrototypeCache cache;
  return cache;
}

}  // namespace

struct RayTracer::State {
  const Scene* scene;
  std::map<const TriangleMesh*, Prototype> prototypes;
  std::vector<Eigen::Matrix3d> normal_maps;
  TracedScene top;
};

RayTracer::RayTracer(const Scene& scene, double duration) : state_(std::make_unique<State>()) {
  state_->scene = &scene;
  RTCDevice device = shared_device();
  state_->top.reset(rtcNewScene(device));
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& placed = scene.instances[i];
    state_->normal_maps.push_back(placed.pose.linear().inverse().transpose());
    if (!placed.mesh || placed.mesh->triangles.empty()) continue;
    auto& prototype = state_->prototypes[placed.mesh.get()];
    if (!prototype) prototype = prototype_cache().find(placed.mesh);
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, prototype.get());
    const Eigen::Vector3d shift =
        placed.object < 0 ? Eigen::Vector3d::Zero().eval()
                          : (0.5 * duration * scene.objects[placed.object].velocity).eval();
    if (shift.isZero()) {
      rtcSetGeometryTimeStepCount(instance, 1);
      set_pose(instance, 0, placed.pose);
    } else {
      rtcSetGeometryTimeStepCount(instance, 2);
      set_pose(instance, 0, Eigen::Translation3d(-shift) * placed.pose);
      set_pose(instance, 1, Eigen::Translation3d(shift) * placed.pose);
    }
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(state_->top.get(), instance, static_cast<unsigned>(i));
    rtcReleaseGeometry(instance);
  }
  rtcCommitScene(state_->top.get());
}

RayTracer::~RayTracer() = default;

bool RayTracer::trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
                      double nearest, double farthest, Hit& hit) const {
  RTCRayHit query{};
  query.ray = ray_of(origin, direction, time, nearest, farthest);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(state_->top.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const Instance& placed = state_->scene->instances[query.hit.instID[0]];
  const Eigen::Vector3d local(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  hit.distance = query.ray.tfar;
  hit.normal = (state_->normal_maps[query.hit.instID[0]] * local).normalized();
  if (hit.normal.dot(direction) > 0) hit.normal = -hit.normal;
  hit.material = placed.mesh->materials[query.hit.primID];
  hit.brightness = placed.brightness;
  hit.object = placed.object;
  hit.instance = static_cast<std::int32_t>(query.hit.instID[0]);
  return true;
}

bool RayTracer::blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double time, double nearest, double farthest) const {
  RTCRay ray = ray_of(origin, direction, time, nearest, farthest);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(state_->top.get(), &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace arbox::simulation
