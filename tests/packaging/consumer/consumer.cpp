#include <arbox/evaluation/ranking.h>
#include <arbox/geometry/overlap.h>
#include <arbox/io/box_table.h>
#include <arbox/io/point_cloud_file.h>

#include <iostream>

int main(int, char** arguments) {
  const auto table = arbox::io::read_box_table(arguments[1]);
  std::cout << "iou " << arbox::geometry::overlap(table.boxes.at(0), table.boxes.at(1));
  const auto file = arbox::io::read_point_cloud(arguments[2]);
  std::cout << ", points " << file.points.size();
  const std::vector<double> scores = {0.9, 0.1};
  std::cout << ", auc " << *arbox::evaluation::roc_auc(scores, {true, false}) << '\n';
}
