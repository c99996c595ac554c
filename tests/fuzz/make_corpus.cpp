// Writes the seed corpora of the fuzz targets: fuzz_make_corpus tests/fuzz/corpus
//
// Every seed is made here from a few numbers; none is cut from a dataset. Files named finding_* in
// a corpus are inputs that once broke a parser; this program leaves them alone.
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/mat_file.h"
#include "arbox/io/internal/mat_image.h"
#include "arbox/io/internal/zip_archive.h"
#include "arbox/io/model_archive.h"
#include "arbox/io/npy.h"
#include "arbox/io/npz.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/io/sunrgbd.h"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& root, const std::string& target, const std::string& name,
           const std::string& content) {
  fs::create_directories(root / target);
  arbox::io::write_file(root / target / name, content);
}

std::string with_header(std::string dictionary, char version, const std::string& data) {
  std::string bytes = "\x93NUMPY";
  bytes += {version, '\0', static_cast<char>(dictionary.size()), '\0'};
  if (version > 1) bytes += {'\0', '\0'};
  return bytes + dictionary + data;
}

void make_npy(const fs::path& root) {
  const std::vector<float> floats{1.5F, -2.0F, 0.25F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};
  const std::vector<std::int64_t> integers{1, -2, 3, 4};
  const auto points = arbox::io::encode_npy<float>(floats, {2, 4});
  const auto labels = arbox::io::encode_npy<std::int64_t>(integers, {4});
  write(root, "npy", "points.npy", points);
  write(root, "npy", "labels.npy", labels);
  write(root, "npy", "empty.npy", arbox::io::encode_npy<float>({}, {0, 4}));
  write(root, "npy", "scalar.npy", arbox::io::encode_npy<float>(std::span(floats).first(1), {}));
  write(root, "npy", "fortran_big_endian.npy",
        with_header("{'descr': '>f2', 'fortran_order': True, 'shape': (3, 2), }\n", 2,
                    std::string("\x3c\x00\x7c\x00\x7e\x00\x00\x01\x80\x00\xbc\x00", 12)));
  write(root, "npy", "bool_version_3.npy",
        with_header("{\"shape\": (3L,), 'descr': '|b1', 'fortran_order': False}", 3,
                    std::string("\1\0\1", 3)));
  write(root, "npz", "one.npz", arbox::io::encode_npz({{"points", points}}));
  write(root, "npz", "two.npz", arbox::io::encode_npz({{"pc", points}, {"labels", labels}}));
}

void make_tables(const fs::path& root) {
  write(root, "box_table", "yaw.csv", "1,2,3,4,5,6,0.5\n-1,-2,-3,4e-1,5,6,-3\n");
  write(root, "box_table", "quaternion.csv",
        "x,y,z,l,w,h,qw,qx,qy,qz\n1,2,3,4,5,6,0.5,0.5,-0.5,0.5\n");
  write(root, "box_table", "named.csv",
        "class;score;yaw;h;w;l;z;y;x;object\n\"a \"\"b\"\", c\";.5;0;1;1;1;0;0;0;7\n");
  write(root, "box_table", "numbers.txt", "# x y z l w h yaw\r\n1 2 3 4 5 6 0\r\n\r\n");
  write(root, "box_table", "class.csv", "1 2 3 4 5 6 0 0.25 Car\n");
}

void make_known_sizes(const fs::path& root) {
  write(root, "known_sizes", "named.csv", "class,l,w,h,name\nCar,4.28,1.79,1.49,Golf\n");
  write(root, "known_sizes", "plain.txt", "Car 4 2 1.5\r\n\r\nTruck 7 2.5 3\r\n");
  write(root, "known_sizes", "turned.csv", "# name;h;w;l;class\n\"a; b\";.5;1;1;\"x \"\"y\"\"\"\n");
}

void make_detections(const fs::path& root) {
  const std::string box = R"({"center":[1,2.5,-3],"size":[4,2,1.5],"rotation":[1,0,0,0],"yaw":0})";
  const std::string detection =
      R"({"class":"Car","score":0.9,"box":)" + box +
      R"(,"log_density":-1.5,"quantile_boxes":[{"q":0.1,"box":)" + box +
      R"(,"fallback":false}],"confidence_boxes":[{"p":0.9,"box":)" + box +
      R"(}],"uncertainty":0.25,"known_size":[4,2,1.5],"known_size_name":"crate","samples":[)" +
      box + "]}";
  const std::string scan = R"({"source":"a.bin","frame":"lidar","detections":[)" + detection + "]}";
  write(root, "detection_json", "box.json", R"({"detections":[{"box":)" + box + "}]}");
  write(root, "detection_json", "scan.json", scan);
  write(root, "detection_json", "scans.jsonl", scan + "\n" + R"({"detections":[]})" + "\n");
  write(root, "detection_json", "array.json", "[" + scan + ",\n " + scan + "]");
}

void make_kitti(const fs::path& root) {
  const std::string car =
      "Car 0.25 1 -1.50 10.00 15.50 20.00 25.00 1.50 1.75 4.25 -2.50 1.75 20.00 -1.62";
  const std::string nothing = "DontCare -1 -1 -10 5 6 7 8 -1 -1 -1 -1000 -1000 -1000 -10";
  write(root, "kitti_label", "two.txt", car + "\n" + nothing + "\n");
  write(root, "kitti_label", "windows.txt", car + "\r\n\r\n");
  write(root, "kitti_result", "two.txt", car + " 0.5\n" + nothing + " 1e-3\n");
  write(root, "kitti_calibration", "whole.txt",
        "P0: 7 0 6 0 0 7 1 0 0 0 1 0\nP1: 7 0 6 -3 0 7 1 0 0 0 1 0\n"
        "P2: 7 0 6 4 0 7 1 0.5 0 0 1 0.005\nP3: 7 0 6 -3 0 7 1 2 0 0 1 0.003\n"
        "R0_rect: 0.96 0 0.28 0 1 0 -0.28 0 0.96\n"
        "Tr_velo_to_cam: 0 -1 0 0.01 0 0 -1 -0.08 1 0 0 -0.27\n"
        "Tr_imu_to_velo: 1 0 0 -0.8 0 1 0 0.3 0 0 1 -0.8\n\n");
  write(root, "kitti_calibration", "tracking.txt",
        "P2 1 0 0 0 0 1 0 0 0 0 1 0\nR_rect 1 0 0 0 1 0 0 0 1\n"
        "Tr_velo_cam 1 0 0 0 0 1 0 0 0 0 1 0\n");
  write(root, "kitti_plane", "plane.txt", "# Matrix\nWIDTH 4\nHEIGHT 1\n0.01 -1 -2e-2 1.65 \n");
  write(root, "kitti_split", "train.txt", "000001\n000003\r\n\n a-b_c.d\n");
  write(
      root, "png_size", "header.png",
      std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x04\xda\0\0\x01\x77\x08\x02\0\0\0\xfc\x53\xb1"
                  "\x8a",
                  33));
}

arbox::geometry::PointCloud make_cloud() {
  arbox::geometry::PointCloud points{
      .channels = {"intensity", "r", "g", "b", "ring", "time", "normal_x", "normal_y", "normal_z"},
      .values = {}};
  for (int i = 0; i < 6; ++i) {
    const auto n = static_cast<float>(i);
    points.values.insert(points.values.end(), {n * 0.5F, -n, 2.0F, n / 8, 1.0F, n / 5, 0.0F, n,
                                               n / 4, 0.0F, 0.0F, 1.0F});
  }
  return points;
}

void make_evaluation(const fs::path& root) {
  const std::string box = "1,-1,2.5,1,-1,1.5,-1,-1,1.5,-1,-1,2.5,1,1,2.5,1,1,1.5,-1,1,1.5,-1,1,2.5";
  write(root, "votenet_boxes", "truth.txt", "0 " + box + "\n\n17 " + box + "\r\n");
  write(root, "votenet_boxes", "predictions.txt", "3 " + box + " 0.5\n3 " + box + " 1e-3\n");
  const std::string family =
      R"({"format": "arbox confidence calibration", "version": 1, "source": "made", )"
      R"("min_iog": 0.95, "quantiles": [0.9, 0.5, 0.1, 0], "quantile_box": )"
      R"({"points_per_box": 64, "placement": "stratified", "corners": true, "refine": false, )"
      R"("seed": 0}, "classes": )";
  write(root, "confidence_calibration", "empty.json", family + "{}}\n");
  write(root, "confidence_calibration", "two_classes.json",
        family + R"({"Car": {"extents": [[0.5, 3], [1.25, 1]], "uncontained": 2}, )" +
            R"("b": {"extents": [], "uncontained": 0}}}
)");
}

void make_point_clouds(const fs::path& root) {
  using arbox::io::PointCloudFormat;
  const auto points = make_cloud();
  const auto encode = [&](PointCloudFormat format, const std::string& encoding,
                          const std::vector<std::string>& channels = {}) {
    return arbox::io::encode_point_cloud(points.view(), format,
                                         {.encoding = encoding, .channels = channels});
  };
  for (const std::string encoding : {"ascii", "binary", "binary_compressed"}) {
    write(root, "point_cloud_pcd", encoding + ".pcd", encode(PointCloudFormat::kPcd, encoding));
  }
  write(root, "point_cloud_pcd", "order_types_counts.pcd",
        "VERSION .7\nFIELDS label _ z normal y rgba x t\nSIZE 2 1 4 4 8 4 1 8\n"
        "TYPE U U F F F F I U\nCOUNT 1 2 1 3 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 0 0 .5 0 0 1 nan 4.2e6 -1 7\n"
        "2 0 0 1e-3 0 1 0 inf 0 12 8\n");
  for (const std::string encoding : {"ascii", "binary"}) {
    write(root, "point_cloud_ply", encoding + ".ply", encode(PointCloudFormat::kPly, encoding));
  }
  const std::string elements =
      "element camera 1\nproperty list uchar char values\nelement vertex 2\nproperty char x\n"
      "property list uchar char near\nproperty uchar y\nproperty char z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  write(root, "point_cloud_ply", "lists_ascii.ply",
        "ply\nformat ascii 1.0\n" + elements + "2 7 8\n1 1 9 2 -3\n4 0 5 6\n2 0 1\n");
  write(root, "point_cloud_ply", "lists_big_endian.ply",
        "ply\nformat binary_big_endian 1.0\n" + elements +
            std::string("\2\7\10\1\1\11\2\3\4\0\5\6\1\0\0\0\1", 17));
  write(root, "point_cloud_text", "header.csv", encode(PointCloudFormat::kText, ""));
  write(root, "point_cloud_text", "semicolons.txt", "1;2;3;0.5;\r\n4;5;-6e0;+1;\r\n");
  write(root, "point_cloud_text", "blanks.xyz", "# made\n//X Y Z nx\n1 2\t3 nan\n\n4 5 -6 inf\n");
  write(root, "point_cloud_text", "count.pts", "2\n1 2 3 9 255 0 7\n4 5 6 8 1 2 3\n");
  write(root, "point_cloud_bin", "four.bin", encode(PointCloudFormat::kBin, ""));
  write(root, "point_cloud_bin", "five.bin",
        encode(PointCloudFormat::kBin, "", {"intensity", "ring"}).substr(0, 100));
}

void make_models(const fs::path& root) {
  arbox::io::ModelArchive model{.kind = "k",
                                .configuration = "a: 1\n",
                                .classes = {"Car", "b"},
                                .calibration = "{}",
                                .card = "# K\n"};
  model.texts["note"] = "text";
  model.records["a.weight"] = arbox::io::make_record<float>(std::vector<float>{1, -2}, {1, 2});
  model.records["b/step"] = arbox::io::make_record<std::int64_t>(std::vector<std::int64_t>{3}, {});
  write(root, "model_archive", "stored.arbox", arbox::io::encode_model_archive(model));
  write(root, "model_archive", "deflated.arbox", arbox::io::encode_model_archive(model, true));
}

std::string text(const std::string& word) { return 'U' + (static_cast<char>(word.size()) + word); }

// A tensor of two floats in storage "0".
std::string tensor() {
  using namespace std::string_literals;
  return "ctorch._utils\n_rebuild_tensor_v2\n((" + text("storage") + "ctorch\nFloatStorage\n" +
         text("0") + text("cpu") + "K\2NtQK\0K\2\x85K\1\x85\x89}tR"s;
}

void make_pickles(const fs::path& root) {
  using namespace std::string_literals;
  const std::string dtype = "cnumpy\ndtype\n(" + text("f4") + "K\0K\1tR(K\3"s + text("<") +
                            "NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb"s;
  const std::string reconstruct =
      "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(K\0t"s + text("b") + "tR(K\1(";
  write(root, "pickle", "protocol_0.pkl",
        "(dp0\nS'a\\n\\x41'\np1\n(lp2\nI1\naF2.5\naL-3L\naI01\nasV\\u4e16\np3\n(g1\ntp4\ns.");
  write(root, "pickle", "protocol_2.pkl",
        "\x80\2}q\0(X\1\0\0\0aq\1]q\2(K\1M\1\2J\1\2\3\xff\x8a\2\1\2G?\xf0\0\0\0\0\0\0eh\1h\2u."s);
  write(
      root, "pickle", "protocol_4.pkl",
      "\x80\4\x95\x1e\0\0\0\0\0\0\0}\x94(\x8c\1a\x94\x8f\x94(K\1\x88N\x90h\1C\2bc\x94K\2\x85\x94u."s);
  write(root, "pickle", "objects.pkl",
        "(cm\nn\n)R}" + text("k") +
            "Nsb(K\1e(K\1Nu\x8c\1m\x8c\1n\x93)}\x92Q(K\1im\nn\n(cm\nn\nK\1ot.");
  write(root, "pickle", "array.pkl",
        "\x80\2" + reconstruct + "K\2t" + dtype + "\x88" + text("12345678") + "tb.");
  write(root, "pickle", "objects_array.pkl",
        "\x80\2" + reconstruct + "K\1tcnumpy\ndtype\n(" + text("O8") + "K\0K\1tR\x89(Nltb."s);
  write(root, "pickle", "encoded.pkl",
        "\x80\2c_codecs\nencode\nX\3\0\0\0\xc3\xbf"s + "aX\6\0\0\0latin1\x86R."s);
  const std::string value = "\x80\2}" + text("w") + tensor() + "s.";
  write(root, "torch_checkpoint", "stream.pth",
        "\x80\2\x8a\nl\xfc\x9c\x46\xf9 j\xa8P\x19.\x80\2M\xe9\3.\x80\2}" + text("little_endian") +
            "\x88s." + value + "\x80\2(" + text("0") + "l.\2\0\0\0\0\0\0\0"s + "\0\0\x80?\0\0\0@"s);
  write(root, "torch_checkpoint", "archive.pth",
        arbox::io::internal::encode_zip(
            {{"a/data.pkl", value}, {"a/byteorder", "little"}, {"a/data/0", "\0\0\x80?\0\0\0@"s}},
            false, "make_corpus"));
}

void make_labels(const fs::path& root) {
  write(root, "label_file", "two.txt", "# made\n1 2 3 4 2 1.5 0.3 Car\n-1 0 0 1 1 1 7 dog\n");
  write(root, "label_file", "two.json",
        R"({"frame": "room", "objects": [{"class": "Car", "heading": "half", "box": )"
        R"({"center": [1, 2, 3], "size": [4, 2, 1], "yaw": 0.3}, "attributes": {"id": 7}}, )"
        R"({"box": {"center": [0, 0, 0], "size": [1, 1, 1], "rotation": [0.5, 0.5, 0.5, 0.5]}}]})");
  write(root, "dataset_description", "dataset.json",
        R"({"format": "arbox dataset", "version": 1, "frame": "lidar", "classes": ["a"], )"
        R"("class_map": {"b": "a", "c": null}, "columns": ["x", "y", "z"]})");
  write(root, "dataset_description", "camera.json",
        R"({"projection": [[5, 0, 3, 0], [0, 5, 2, 0], [0, 0, 1, 0]], "image_size": [640, 480]})");
  write(
      root, "annotation_tools", "centroid.json",
      R"({"filename": "a.pcd", "objects": [{"name": "cart", "centroid": {"x": 1, "y": 2, "z": 3}, )"
      R"("dimensions": {"length": 4, "width": 2, "height": 1}, )"
      R"("rotations": {"x": 0, "y": 0, "z": 270}}]})");
  write(root, "annotation_tools", "vertices.json",
        R"({"objects": [{"name": "a", "vertices": [[0,0,0],[0,1,0],[1,1,0],[1,0,0],)"
        R"([0,0,1],[0,1,1],[1,1,1],[1,0,1]]}]})");
  write(root, "annotation_tools", "untransformed.txt", "cart 0 0 0 0 0 0 0 1 2 4 1 2 3 0.5\n");
  write(root, "annotation_tools", "tracklets.xml",
        "<?xml version=\"1.0\"?>\n<boost_serialization><tracklets><count>1</count><item>"
        "<objectType>car</objectType><h>1.8</h><w>4.2</w><l>1.5</l><first_frame>1</first_frame>"
        "<poses><item><tx>1</tx><ty>2</ty><tz>0</tz><rx>0</rx><ry>0</ry><rz>0.3</rz>"
        "<truncation>0</truncation></item></poses></item></tracklets></boost_serialization>\n");
}

void make_rooms(const fs::path& root) {
  write(root, "scannet", "segments", R"(0{"params":{"a":[1,[2]]},"segIndices":[1,1,2,700]})");
  write(root, "scannet", "aggregation",
        R"(1{"segGroups":[{"objectId":0,"label":"office chair","segments":[1,2]}]})");
  write(root, "scannet", "alignment",
        "2axisAlignment = 0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1 \nx = y\n");
  write(root, "scannet", "label_map", "3id\traw_category\tnyu40id\n1\tchair\t5\n2\tx\t\n");
  write(root, "sunrgbd", "label.txt", "bed 1 2 3 4 1 2 3 0.5 1 0.25 0.6 -0.8\n");
  write(root, "sunrgbd", "calib.txt", "1 0 0 0 1 0 0 0 1\n529.5 0 0 0 529.5 0 365 265 1\n");
  const fs::path file = root / "sunrgbd_toolbox" / "instance.mat";
  fs::create_directories(file.parent_path());
  arbox::io::internal::write_mat_matrix(file, "instance", {2, 3, {1, 2, 3, 4, 5, 6}});
  const arbox::io::SunRgbdAnnotation image{
      .number = 2,
      .calibration = {},
      .objects = {arbox::io::to_object(
          arbox::io::parse_sunrgbd_labels("bed 1 2 3 4 1 2 3 0.5 1 0.25 0.6 -0.8\n", "made")[0])}};
  arbox::io::write_sunrgbd_toolbox(root / "sunrgbd_toolbox" / "packed.mat", {&image, 1});
  write(root, "sunrgbd_toolbox", "plain.mat",
        arbox::io::internal::unpacked_mat(
            arbox::io::read_file(root / "sunrgbd_toolbox" / "packed.mat"), "made"));
  write(root, "mmdet3d", "old.pkl",
        "(lp0\n(dp1\nVpoint_cloud\n(dp2\nVlidar_idx\nI1\nssVannos\n(dp3\nVgt_num\nI0\nssa.");
  write(root, "mmdet3d", "new.pkl",
        "(dp0\nVmetainfo\n(dp1\nVcategories\n(dp2\nVbed\nI0\nsssVdata_list\n(lp3\n(dp4\n"
        "Vlidar_points\n(dp5\nVlidar_path\nV1.bin\nssVinstances\n(lp6\n(dp7\nVbbox_3d\n(lp8\n"
        "F1\naF2\naF3\naF1\naF1\naF1\nasVbbox_label_3d\nI0\nsasas.");
  const std::vector<float> depth{1, 2, 0, 4};
  const std::vector<double> intrinsic{5, 0, 1, 0, 5, 1, 0, 0, 1};
  const std::vector<double> row{1, 1, 1}, turn{1, 0, 0, 0};
  const std::vector<std::uint8_t> mask{0, 1, 1, 0};
  using arbox::io::encode_npy;
  const auto first_version = [&](char part, const char* name, const auto& arrays) {
    write(root, "cob3d", name, part + arbox::io::encode_npz(arrays));
  };
  using Arrays = std::vector<std::pair<std::string, std::string>>;
  first_version('\0', "data",
                Arrays{{"depth", encode_npy<float>(depth, {2, 2})},
                       {"intrinsic", encode_npy<double>(intrinsic, {3, 3})}});
  first_version('\1', "segm",
                Arrays{{"masks", encode_npy<std::uint8_t>(mask, {1, 2, 2})},
                       {"masks_amodal", encode_npy<float>(depth, {1, 2, 2})}});
  first_version('\2', "bbox3d",
                Arrays{{"dimensions", encode_npy<double>(row, {1, 3})},
                       {"centers", encode_npy<double>(row, {1, 3})},
                       {"orientations", encode_npy<double>(turn, {1, 4})}});
  const std::string object = "{'descr': '|O', 'fortran_order': False, 'shape': ()}\n";
  write(root, "cob3d_v2", "scene.npz",
        arbox::io::encode_npz({{"depth_map", arbox::io::encode_npy<float>(depth, {2, 2})},
                               {"intrinsic", arbox::io::encode_npy<double>(intrinsic, {3, 3})},
                               {"segm", with_header(object, 1, "(lp0\n(dp1\na.")}}));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_make_corpus FOLDER\n";
    return 2;
  }
  try {
    make_npy(argv[1]);
    make_tables(argv[1]);
    make_known_sizes(argv[1]);
    make_detections(argv[1]);
    make_kitti(argv[1]);
    make_evaluation(argv[1]);
    make_point_clouds(argv[1]);
    make_labels(argv[1]);
    make_rooms(argv[1]);
    make_models(argv[1]);
    make_pickles(argv[1]);
  } catch (const arbox::Error& error) {
    std::cerr << "fuzz_make_corpus: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
