#include "arbox/plugins/pcl/box_filter.h"

namespace arbox::pcl {

template class BoxDetector<::pcl::PointXYZ>;
template class BoxDetector<::pcl::PointXYZI>;
template class BoxDetector<::pcl::PointXYZRGB>;
template class BoxDetector<::pcl::PointXYZRGBNormal>;
template class BoxFilter<::pcl::PointXYZ>;
template class BoxFilter<::pcl::PointXYZI>;
template class BoxFilter<::pcl::PointXYZRGB>;
template class BoxFilter<::pcl::PointXYZRGBNormal>;

}  // namespace arbox::pcl
