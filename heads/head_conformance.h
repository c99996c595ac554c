#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arbox/heads/box_head.h"

/// \file
/// What every head must keep, for the tests of its author. With GoogleTest:
///
///     TEST(MyHead, Conforms) {
///       EXPECT_EQ(arbox::heads::head_violations(make_my_head), std::vector<std::string>{});
///     }
///
/// or in one line ARBOX_TEST_HEAD(MyHead, make_my_head). Needs no files and a few seconds.

namespace arbox::heads {

/// Builds the head for a context; called several times.
using HeadMaker = std::function<std::shared_ptr<BoxHead>(const HeadContext& context)>;

/// Runs the head with every codec that it takes (those for which `make` throws ConfigError or
/// NotAvailable are left out; at least one must remain), with and without condition. Gives one text
/// for each broken promise, empty if it conforms:
///
/// - shapes of all answers, also for no objects and for one;
/// - boxes that geometry accepts: finite, sizes above zero, unit quaternions;
/// - mode() best first; equal streams give equal draws; an object's draws, mode and density do not
///   depend on the batch, nor on whether select() came before;
/// - a likelihood exactly where measure() says so, and an upright box at least as likely as its
///   vector; where sizes may be given, all boxes have them;
/// - losses per object that are finite, independent of the batch, reach features and parameters
///   with a finite gradient, and fall when trained on one batch;
/// - parameters that, loaded into a second head, give the same answers;
/// - InvalidArgument for wrong shapes, NumericalError naming the tensor for non-finite features.
std::vector<std::string> head_violations(const HeadMaker& make);

}  // namespace arbox::heads

/// Defines a GoogleTest case (include gtest first).
#define ARBOX_TEST_HEAD(suite, make)                                              \
  TEST(suite, ConformsToTheInterfaceOfHeads) {                                    \
    EXPECT_EQ(::arbox::heads::head_violations(make), std::vector<std::string>{}); \
  }
