#include "arbox/io/mmdet3d.h"

#include <gtest/gtest.h>

#include "arbox/io/dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/sunrgbd.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox {
namespace {

using testing::expect_refusal;
using testing::TemporaryDirectory;

/// Writes the infos of both generations for the labels in SUN RGB-D's extraction, as
/// mmdetection3d's two converters do.
constexpr const char* kMakeSun = R"(
import sys, pickle, numpy as np
root, out, protocol = sys.argv[1], sys.argv[2], int(sys.argv[3])
CLASSES = ['bed', 'table', 'sofa', 'chair', 'toilet', 'desk', 'dresser', 'night_stand', 'bookshelf', 'bathtub']
old, middle, new = [], [], []
for i in (1, 2, 3):
    lines = [l.split() for l in open(f'{root}/label/{i:06d}.txt')]
    lines = [[l[0]] + [float(x) for x in l[1:]] for l in lines if l[0] in CLASSES]
    calib = [np.array([float(x) for x in l.split()]) for l in open(f'{root}/calib/{i:06d}.txt')]
    Rt, K = calib[0].reshape(3, 3, order='F'), calib[1]
    def annos(sign, lhw):
        size = [[l[9], l[8], l[10]] for l in lines]
        yaw = [sign * np.arctan2(l[12], l[11]) for l in lines]
        return dict(gt_num=len(lines), name=np.array([l[0] for l in lines]),
            bbox=np.array([[l[1], l[2], l[1] + l[3], l[2] + l[4]] for l in lines]),
            location=np.array([l[5:8] for l in lines]),
            dimensions=2 * np.array([[s[0], s[2], s[1]] if lhw else s for s in size]),
            rotation_y=np.array(yaw), index=np.arange(len(lines), dtype=np.int32),
            **{'class': np.array([CLASSES.index(l[0]) for l in lines])},
            gt_boxes_upright_depth=np.array([l[5:8] + [2 * x for x in s] + [y] for l, s, y in zip(lines, size, yaw)]))
    image = dict(image_idx=i, image_shape=np.array([530, 730], np.int32), image_path=f'image/{i:06d}.jpg')
    common = dict(point_cloud=dict(num_features=6, lidar_idx=i), pts_path=f'points/{i:06d}.bin', image=image)
    old.append(dict(common, calib=dict(K=K, Rt=Rt), annos=annos(-1, True)))
    K3 = K.reshape(3, 3, order='F').astype(np.float32)
    middle.append(dict(common, calib=dict(K=K3, Rt=Rt.astype(np.float32)), annos=annos(1, False)))
    a = annos(1, False)
    img = K3 @ (np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) @ Rt.T)
    new.append(dict(lidar_points=dict(num_pts_feats=6, lidar_path=f'{i:06d}.bin'),
        images=dict(CAM0=dict(depth2img=img.tolist(), img_path=f'{i:06d}.jpg', height=530, width=730)),
        instances=[dict(bbox_3d=b.tolist(), bbox=q.tolist(), bbox_label_3d=c, bbox_label=c)
                   for b, q, c in zip(a['gt_boxes_upright_depth'], a['bbox'], a['class'])]))
new = dict(metainfo=dict(categories={k: i for i, k in enumerate(CLASSES)}, dataset='sunrgbd', info_version='1.1'), data_list=new)
for name, data in (('old', old), ('middle', middle), ('new', new)):
    pickle.dump(data, open(f'{out}/{name}.pkl', 'wb'), protocol)
)";

TEST(Mmdet3d, YawSensesOfAllGenerationsAreToldApart) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd/sunrgbd_trainval");
  const auto truth = io::open_dataset(root);
  for (const std::string protocol : {"2", "4"}) {
    const TemporaryDirectory folder;
    const auto made = testing::run(
        "/usr/bin/python3", {"-c", kMakeSun, root.string(), folder.path().string(), protocol});
    ASSERT_EQ(made.exit_code, 0) << made.errors;
    for (const std::string generation : {"old", "middle", "new"}) {
      const std::string base = generation + "_folder/";
      folder.write(base + "sunrgbd_infos_val.pkl", io::read_file(folder / (generation + ".pkl")));
      for (const auto& name : truth->names("all")) {
        const auto scene = truth->load("all", name);
        folder.write(base + "points/" + name + ".bin",
                     {reinterpret_cast<const char*>(scene.cloud.values.data()),
                      scene.cloud.values.size() * sizeof(float)});
      }
      const auto dataset = io::open_dataset(folder / (generation + "_folder"));
      EXPECT_EQ(dataset->layout(), "sunrgbd-mmdet3d");
      for (const auto& name : dataset->names("val")) {
        const auto scene = dataset->load("val", name), expected = truth->load("all", name);
        ASSERT_EQ(scene.objects.size(), expected.objects.size());
        EXPECT_EQ(scene.cloud.values, expected.cloud.values);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
          EXPECT_EQ(scene.objects[i].label, expected.objects[i].label);
          EXPECT_LE((scene.objects[i].box.size - expected.objects[i].box.size).norm(), 1e-9);
          EXPECT_NEAR(geometry::wrap_angle(geometry::yaw(scene.objects[i].box) -
                                           geometry::yaw(expected.objects[i].box)),
                      0.0, 1e-9)
              << generation;
          for (const char* edge : {"left", "top", "right", "bottom"}) {
            EXPECT_NEAR(scene.objects[i].attributes.at(edge),
                        expected.objects[i].attributes.at(edge), 1e-9);
          }
        }
      }
      // The 2-D boxes alone tell it, too, and told wrongly it is wrong.
      auto infos = io::read_mmdet3d_infos(io::read_pickle(folder / (generation + ".pkl")));
      const auto sense = io::find_yaw_sense(infos);
      EXPECT_EQ(sense,
                generation == "old" ? io::YawSense::kClockwise : io::YawSense::kCounterClockwise);
    }
  }
}

constexpr const char* kMakeScanNet = R"(
import sys, pickle, numpy as np
out = sys.argv[1]
CLASSES = ['cabinet', 'bed', 'chair']
matrix = np.array([[0., -1, 0, 10], [1, 0, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
boxes = np.array([[7, 1.5, 1.5, 2, 1, 1], [1, 2, 3, 4, 5, 6.]])
old = [dict(point_cloud=dict(num_features=6, lidar_idx='scene0000_00'), pts_path='points/scene0000_00.bin',
            annos=dict(gt_num=2, name=np.array(['chair', 'bed']), location=boxes[:, :3], dimensions=boxes[:, 3:],
                       gt_boxes_upright_depth=boxes, **{'class': np.array([2, 1])}, axis_align_matrix=matrix)),
       dict(point_cloud=dict(num_features=6, lidar_idx='scene0001_00'), pts_path='points/scene0001_00.bin',
            annos=dict(gt_num=0, axis_align_matrix=matrix))]
new = dict(metainfo=dict(categories={k: i for i, k in enumerate(CLASSES)}),
           data_list=[dict(lidar_points=dict(num_pts_feats=6, lidar_path='scene0000_00.bin'), axis_align_matrix=matrix.tolist(),
                           instances=[dict(bbox_3d=b.tolist(), bbox_label_3d=c) for b, c in zip(boxes, (2, 1))]),
                      dict(lidar_points=dict(num_pts_feats=6, lidar_path='scene0001_00.bin'), axis_align_matrix=matrix.tolist(), instances=[])])
pickle.dump(old, open(out + '/old.pkl', 'wb'))
pickle.dump(new, open(out + '/new.pkl', 'wb'))
)";

TEST(Mmdet3d, ScanNetPointsAreAlignedInBothGenerations) {
  const TemporaryDirectory folder;
  const auto made = testing::run("/usr/bin/python3", {"-c", kMakeScanNet, folder.path().string()});
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  const std::vector<float> points = {1, 2, 0, 255, 0, 51, 2, 4, 1, 0, 0, 0};
  for (const std::string generation : {"old", "new"}) {
    const std::string base = generation + "_folder/";
    folder.write(base + "scannet_infos_train.pkl", io::read_file(folder / (generation + ".pkl")));
    folder.write(base + "points/scene0000_00.bin",
                 {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float)});
    folder.write(base + "points/scene0001_00.bin", "");
    const auto dataset = io::open_dataset(folder / (generation + "_folder"));
    EXPECT_EQ(dataset->layout(), "scannet-mmdet3d");
    const auto scene = dataset->load("train", "scene0000_00");
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[0].label, "chair");
    EXPECT_EQ(scene.objects[0].box.size, Eigen::Vector3d(2, 1, 1));
    EXPECT_EQ(scene.cloud.view().position(0), Eigen::Vector3f(8, 1, 1));
    EXPECT_FLOAT_EQ(scene.cloud.values[5], 0.2F);
    const auto empty = dataset->load("train", "scene0001_00");
    EXPECT_TRUE(empty.labelled);
    EXPECT_TRUE(empty.objects.empty());
  }
}

TEST(Mmdet3d, RefusesWhatIsNoInfos) {
  const TemporaryDirectory folder;
  folder.write("scannet_infos_val.pkl", "not a pickle");
  expect_refusal([&] { io::open_dataset(folder.path()); }, {"scannet_infos_val.pkl"});
  // [{}]
  folder.write("scannet_infos_val.pkl", std::string("\x80\x02]}a.", 6));
  expect_refusal([&] { io::open_dataset(folder.path()); },
                 {"scannet_infos_val.pkl", "point_cloud"});
}

}  // namespace
}  // namespace arbox
