#include <arbox/geometry/overlap.h>
#include <arbox/io/box_table.h>

#include <iostream>

int main(int, char** arguments) {
  const auto table = arbox::io::read_box_table(arguments[1]);
  std::cout << "iou " << arbox::geometry::overlap(table.boxes.at(0), table.boxes.at(1)) << '\n';
}
