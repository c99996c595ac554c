#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "arbox/base/error.h"
#include "base/options_fixture.h"

namespace {

using arbox::bind_options;
using arbox::ConfigError;
using arbox::options_table;
using arbox::override_options;
using arbox::validate_options;
using arbox::testing::AllOptions;
using arbox::testing::MergeOptions;
using arbox::testing::Overlap;
using ::testing::AllOf;
using ::testing::HasSubstr;

template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no ConfigError";
  return "";
}

TEST(Override, ChangesEveryTypeOfField) {
  const auto options = override_options(
      AllOptions(),
      {"voxel_size=1e-2", "score=.5", "layers=+4", "offset=-9223372036854775808", "seed=7",
       "flip=true", "name=a=b", "mode=exact", "quantiles=[0, 1, 0.5]", "classes=[Van, 'a, b']",
       "mask=[true, false]", "extent=[4, 5, 6]", "note=hello", "reach=70", "nms.threshold=0.7",
       "nms.overlap=iog", "nms.limit=9"});
  EXPECT_EQ(options.voxel_size, 0.01);
  EXPECT_EQ(options.score, 0.5F);
  EXPECT_EQ(options.layers, 4);
  EXPECT_EQ(options.offset, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(options.seed, 7U);
  EXPECT_TRUE(options.flip);
  EXPECT_EQ(options.name, "a=b");
  EXPECT_EQ(options.mode, "exact");
  EXPECT_EQ(options.quantiles, (std::vector<double>{0, 1, 0.5}));
  EXPECT_EQ(options.classes, (std::vector<std::string>{"Van", "a, b"}));
  EXPECT_EQ(options.mask, (std::vector<bool>{true, false}));
  EXPECT_EQ(options.extent, (std::array<double, 3>{4, 5, 6}));
  EXPECT_EQ(options.note, "hello");
  EXPECT_EQ(options.reach, 70);
  EXPECT_EQ(options.nms.threshold, 0.7);
  EXPECT_EQ(options.nms.overlap, Overlap::kIog);
  EXPECT_EQ(options.nms.limit, 9);
}

TEST(Override, LaterWinsAndNullEmptiesAnOptional) {
  const auto options =
      override_options(AllOptions(), {"nms.limit=3", "nms.limit=null", "note=x", "note=null",
                                      "layers=1", "layers=2", "quantiles=[]", "name="});
  EXPECT_EQ(options.nms.limit, std::nullopt);
  EXPECT_EQ(options.note, std::nullopt);
  EXPECT_EQ(options.layers, 2);
  EXPECT_TRUE(options.quantiles.empty());
  EXPECT_EQ(options.name, "");
}

TEST(Override, RefusesEveryWrongValueWithWhatWasExpectedAndWhatCame) {
  const auto refused = [](const std::string& assignment) {
    return error_of([&] { override_options(AllOptions(), {assignment}); });
  };
  EXPECT_EQ(refused("voxel_size=20"), "voxel_size: expected number from 0.001 to 10 (m), got '20'");
  EXPECT_EQ(refused("layers=0"), "layers: expected integer of at least 1, got '0'");
  EXPECT_EQ(refused("offset=1"), "offset: expected integer of at most 0, got '1'");
  EXPECT_EQ(refused("mode=slow"), "mode: expected one of fast, exact, got 'slow'");
  EXPECT_EQ(refused("nms.overlap=giou"), "nms.overlap: expected one of iou, iog, got 'giou'");
  EXPECT_EQ(refused("flip=1"), "flip: expected true or false, got '1'");
  EXPECT_EQ(refused("extent=[1, 2]"),
            "extent: expected list of 3 numbers of at least 0 (m), got [1, 2]");
  EXPECT_EQ(refused("quantiles=[0.5, 2]"),
            "quantiles: expected list of numbers from 0 to 1, got [0.5, 2]");
  EXPECT_EQ(refused("quantiles=0.5"), "quantiles: expected list of numbers from 0 to 1, got '0.5'");
  EXPECT_EQ(refused("nms.limit=x"), "nms.limit: expected integer of at least 1, or null, got 'x'");
  for (const char* word : {"", "nan", "1,5", "1.5x", "null", "0x10", " 1", "1 ", "--1", "+-1"}) {
    EXPECT_THAT(refused("voxel_size=" + std::string(word)), HasSubstr("expected number"));
  }
  for (const char* word : {"1.5", "1e3", "99999999999", "four", "true"}) {
    EXPECT_THAT(refused("layers=" + std::string(word)), HasSubstr("expected integer")) << word;
  }
  EXPECT_THAT(refused("seed=-1"), HasSubstr("expected integer"));
  EXPECT_THAT(refused("extent=[nan, 1, 1]"), HasSubstr("expected list of 3"));
  EXPECT_THAT(refused("extent=[1, [2], 3]"), HasSubstr("expected list of 3"));
  EXPECT_THAT(refused("extent=[1, 2"), HasSubstr("not YAML"));
}

TEST(Override, RefusesUnknownKeysAndNamesTheNearest) {
  const auto error = error_of([] {
    override_options(AllOptions(), {"voxl_size=1", "nms.treshold=1", "threshold=1", "nms=3",
                                    "layers", "=3", "nms.=1", "n.x=1"});
  });
  EXPECT_THAT(error,
              AllOf(HasSubstr("unknown key 'voxl_size', nearest is 'voxel_size'"),
                    HasSubstr("unknown key 'nms.treshold', nearest is 'nms.threshold'; known: "
                              "nms.threshold, nms.overlap, nms.limit"),
                    HasSubstr("unknown key 'threshold', nearest is 'nms.threshold'"),
                    HasSubstr("nms: is a group"), HasSubstr("'layers': expected key=value"),
                    HasSubstr("unknown key ''"), HasSubstr("unknown key 'nms.'"),
                    HasSubstr("unknown key 'n.x'")));
}

TEST(Override, LeavesTheCallersStructAlone) {
  const AllOptions before;
  EXPECT_THROW(override_options(before, {"layers=9", "layers=0"}), ConfigError);
  EXPECT_EQ(before.layers, 3);
}

TEST(Validate, DefaultsAreValid) { EXPECT_NO_THROW(validate_options(AllOptions(), "test")); }

TEST(Validate, ListsEveryViolationOfAStructInMemory) {
  AllOptions options;
  options.voxel_size = std::nan("");
  options.score = 2;
  options.mode = "slow";
  options.extent[1] = -1;
  options.nms.limit = 0;
  options.nms.overlap = static_cast<Overlap>(7);
  EXPECT_EQ(error_of([&] { validate_options(options, "pv_rcnn"); }),
            "pv_rcnn: voxel_size: expected number from 0.001 to 10 (m), got .nan; score: expected "
            "number from 0 to 1, got 2; mode: expected one of fast, exact, got slow; extent: "
            "expected list of 3 numbers of at least 0 (m), got [1, -1, 3]; nms.overlap: expected "
            "one of iou, iog, got 7; nms.limit: expected integer of at least 1, or null, got 0");
}

TEST(OptionsTable, HasOneRowAFieldAndKeepsItsColumns) {
  AllOptions options;
  const std::string table = options_table(bind_options(options));
  EXPECT_THAT(
      table,
      HasSubstr("| `voxel_size` | number from 0.001 to 10 | `0.05` | m | Edge of a voxel |"));
  EXPECT_THAT(table, HasSubstr("Seed of a \\| b"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2 + 17);
}

TEST(MakeOptions, GivesDefaultsThatLiveAsLongAsTheInstance) {
  const arbox::OptionsMaker maker = &arbox::make_options<MergeOptions>;
  const arbox::OptionsInstance instance = maker();
  ASSERT_EQ(instance.fields.fields.size(), 3U);
  EXPECT_EQ(option_text(instance.fields.fields[0]), "0.5");
  EXPECT_EQ(option_text(instance.fields.fields[1]), "iou");
  EXPECT_EQ(option_text(instance.fields.fields[2]), "null");
}

}  // namespace
