#include "arbox/io/model_archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/zip_archive.h"
#include "arbox/io/model_search.h"
#include "arbox/io/npy.h"
#include "arbox/io/npz.h"
#include "support/program.h"

namespace arbox::io {
namespace {

using internal::ZipMember;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

ModelArchive made_archive() {
  ModelArchive archive;
  archive.kind = "pv_rcnn";
  archive.configuration = "voxel_size: [0.05, 0.05, 0.1]\n";
  archive.classes = {"Car", "Pedestrian \"small\"", "Vélo"};
  archive.calibration = "{\"format\": \"arbox confidence calibration\"}\n";
  archive.card = "# A model\n";
  archive.texts = {{"run/seed.txt", "7"}, {"empty", ""}};
  const std::vector<float> weights{1.5F, -2, 0, std::numeric_limits<float>::max(), 5, 6};
  archive.records["backbone_3d.conv.0.weight"] = make_record<float>(weights, {3, 2});
  archive.records["optimizer/step"] = make_record<std::int64_t>(std::vector<std::int64_t>{9}, {});
  archive.records["none"] = make_record<double>({}, {0, 4});
  archive.records["half"] = {NumberType::kFloat16, {2}, std::string("\x00\x3c\x00\xc0", 4)};
  archive.records["mask"] = {NumberType::kBool, {3}, std::string("\1\0\1", 3)};
  return archive;
}

std::string message_of(const std::function<void()>& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string parsed(const std::string& bytes) {
  return message_of([&] { parse_model_archive(bytes, "m.arbox"); });
}

std::string manifest(const std::string& changes = "", const std::string& records = "[]") {
  return R"({"format": "arbox model", "version": 1, "kind": "k", "classes": [], "texts": [], )" +
         changes + R"("records": )" + records + "}";
}

std::string zip(const std::vector<ZipMember>& members, bool deflate = false) {
  return internal::encode_zip(members, deflate, "test");
}

TEST(ModelArchive, ReadsBackWhatWasWritten) {
  const ModelArchive archive = made_archive();
  for (const bool deflate : {false, true}) {
    const std::string bytes = encode_model_archive(archive, deflate);
    EXPECT_TRUE(is_model_archive(std::string_view(bytes).substr(0, 64)));
    EXPECT_EQ(parse_model_archive(bytes, "m.arbox"), archive);
    EXPECT_EQ(bytes, encode_model_archive(archive, deflate)) << "equal archives, equal bytes";
  }
  const ModelArchive least{.kind = "k"};
  EXPECT_EQ(parse_model_archive(encode_model_archive(least), "m.arbox"), least);
}

TEST(ModelArchive, RecordsGiveTheirNumbers) {
  const ModelArchive archive = made_archive();
  EXPECT_THAT(archive.records.at("half").values<float>(), ElementsAre(1.0F, -2.0F));
  EXPECT_THAT(archive.records.at("mask").values<std::uint8_t>(), ElementsAre(1, 0, 1));
  EXPECT_THAT(archive.records.at("optimizer/step").values<std::int64_t>(), ElementsAre(9));
  EXPECT_EQ(archive.records.at("none").count(), 0U);
  EXPECT_THROW(make_record<float>(std::vector<float>(3), {2}), InvalidArgument);
  EXPECT_THROW((ModelRecord{.shape = {2}, .data = "1234"}.values<float>()), InvalidArgument);
}

TEST(ModelArchive, IsWrittenWhole) {
  const testing::TemporaryDirectory folder;
  const ModelArchive archive = made_archive();
  write_model_archive(folder / "m.arbox", archive);
  EXPECT_EQ(read_model_archive(folder / "m.arbox"), archive);
  EXPECT_EQ(testing::slurp(folder / "m.arbox"), encode_model_archive(archive));
  EXPECT_THROW(write_model_archive(folder / "no/m.arbox", archive), IoError);
  EXPECT_THROW(read_model_archive(folder / "no.arbox"), IoError);
}

TEST(ModelArchive, NumpyReadsTheRecords) {
  const testing::TemporaryDirectory folder;
  write_model_archive(folder / "m.arbox", made_archive(), true);
  const auto result = testing::run(
      "/usr/bin/python3",
      {"-c",
       "import numpy, sys\n"
       "m = numpy.load(sys.argv[1])\n"
       "print(m['records/backbone_3d.conv.0.weight'].tolist()[0], m['records/half'].dtype,\n"
       "      m['records/half'].tolist(), m['records/none'].shape, m['records/optimizer/step'])",
       (folder / "m.arbox").string()});
  EXPECT_EQ(result.output, "[1.5, -2.0] float16 [1.0, -2.0] (0, 4) 9\n") << result.errors;
}

TEST(ModelArchive, EveryTruncationIsAnError) {
  const std::string bytes = encode_model_archive(made_archive());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_NE(parsed(bytes.substr(0, length)), "no error") << length;
  }
  EXPECT_THAT(parsed(bytes.substr(0, 500)),
              AllOf(HasSubstr("m.arbox: "), HasSubstr("truncated or damaged")));
}

TEST(ModelArchive, NoDamagedByteGoesUnseen) {
  const ModelArchive archive = made_archive();
  for (const bool deflate : {false, true}) {
    const std::string bytes = encode_model_archive(archive, deflate);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (const char flip : {'\x01', '\x80'}) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ flip);
        try {
          EXPECT_EQ(parse_model_archive(damaged, "m.arbox"), archive) << "byte " << i;
        } catch (const FormatError&) {
        }
      }
    }
  }
}

TEST(ModelArchive, RefusesOtherFiles) {
  EXPECT_THAT(parsed(""), HasSubstr("expected an Arbox model, got an empty file"));
  EXPECT_THAT(parsed("PCD"), HasSubstr("m.arbox: expected an Arbox model (zip archive)"));
  const std::string npz = encode_npz({{"pc", encode_npy<float>(std::vector<float>(4), {4})}});
  EXPECT_THAT(parsed(npz), HasSubstr("a zip archive without arbox.json"));
  EXPECT_FALSE(is_model_archive(npz));
  EXPECT_FALSE(is_model_archive(""));
}

TEST(ModelArchive, RefusesWhatItsManifestDoesNotTell) {
  const std::string record = encode_npy<float>(std::vector<float>(2), {2});
  const std::string wanting = manifest("", R"(["a"])");
  EXPECT_EQ(parsed(zip({{"arbox.json", wanting}, {"records/a.npy", record}})), "no error");
  EXPECT_THAT(parsed(zip({{"arbox.json", wanting}})),
              HasSubstr("expected the entry 'records/a.npy', which is missing"));
  EXPECT_THAT(parsed(zip({{"arbox.json", manifest()}, {"records/a.npy", record}})),
              HasSubstr("holds 'records/a.npy', which is not among"));
  EXPECT_THAT(parsed(zip({{"arbox.json", wanting}, {"records/a.npy", record + "x"}})),
              AllOf(HasSubstr("entry 'records/a.npy'"), HasSubstr("expected 8 bytes of numbers")));
  EXPECT_THAT(parsed(zip({{"arbox.json", wanting}, {"records/a.npy", record.substr(0, 130)}})),
              HasSubstr("expected 8 bytes of data for shape (2) of float32, got 2"));
  std::string fortran = record;
  fortran.replace(fortran.find("False"), 5, "True ");
  EXPECT_THAT(parsed(zip({{"arbox.json", wanting}, {"records/a.npy", fortran}})),
              HasSubstr("in C order"));
  std::string later = manifest();
  later.replace(later.find("1,"), 1, "2");
  EXPECT_THAT(parsed(zip({{"arbox.json", later}})),
              AllOf(HasSubstr("expected version 1"), HasSubstr("got 2")));
  EXPECT_THAT(parsed(zip({{"arbox.json", "{"}})), HasSubstr("expected JSON"));
  EXPECT_THAT(parsed(zip({{"arbox.json", "{}"}})), HasSubstr("expected the key 'format'"));
  EXPECT_THAT(parsed(zip({{"arbox.json", manifest(R"("more": 1, )")}})), HasSubstr("got 'more'"));
  EXPECT_THAT(parsed(zip({{"arbox.json", manifest("", R"(["../a"])")}})),
              HasSubstr("the name of an entry"));
  EXPECT_THAT(parsed(zip({{"arbox.json", manifest("", R"(["a", "a"])")}})),
              HasSubstr("names that are different"));
}

TEST(ModelArchive, RefusesZipBombs) {
  const std::string zeros(300 << 20, '\0');
  const std::string bomb =
      zip({{"arbox.json", manifest("", R"(["a"])")}, {"records/a.npy", zeros}}, true);
  EXPECT_LT(bomb.size(), 1U << 20);
  EXPECT_THAT(parsed(bomb), HasSubstr("unpacks to more than the limit of 268435456 bytes"));
}

TEST(ModelArchive, WritesNoFileThatItWouldRefuse) {
  ModelArchive archive{.kind = "k"};
  archive.records["zeros"] = {NumberType::kUint8, {300 << 20}, std::string(300 << 20, '\0')};
  const std::string bytes = encode_model_archive(archive, true);
  EXPECT_EQ(parse_model_archive(bytes, "m.arbox").records.at("zeros").shape[0], 300U << 20);
}

TEST(ModelArchive, RefusesToWriteWhatCannotBeRead) {
  const auto refused = [](const std::function<void(ModelArchive&)>& change) {
    ModelArchive archive = made_archive();
    change(archive);
    return message_of([&] { encode_model_archive(archive); });
  };
  EXPECT_THAT(refused([](ModelArchive& m) { m.kind.clear(); }), HasSubstr("kind"));
  EXPECT_THAT(refused([](ModelArchive& m) { m.classes.push_back("Car"); }), HasSubstr("'Car'"));
  EXPECT_THAT(refused([](ModelArchive& m) { m.classes[0].clear(); }), HasSubstr("empty"));
  for (const char* name : {"", "/a", "a/", "a//b", "../a", "a/./b", "a b", "a\n", "\xc3\xa9"}) {
    EXPECT_THAT(refused([&](ModelArchive& m) { m.records[name] = {}; }), HasSubstr("record name"));
    EXPECT_THAT(refused([&](ModelArchive& m) { m.texts[name] = "x"; }), HasSubstr("text name"));
  }
  EXPECT_THAT(refused([](ModelArchive& m) { m.records["half"].shape = {3}; }),
              AllOf(HasSubstr("record 'half'"), HasSubstr("3 numbers of float16, got 4 bytes")));
}

TEST(ModelSearch, FindsPathsAndNames) {
  const testing::TemporaryDirectory folder;
  const auto file = folder.write("models/car.arbox", "x");
  EXPECT_EQ(find_model(file.string()), file);
  ::setenv("ARBOX_MODEL_PATH", (folder / "models").c_str(), 1);
  EXPECT_EQ(find_model("car"), file);
  EXPECT_EQ(model_folders().front(), folder / "models");
  EXPECT_THAT(message_of([] { find_model("cat"); }),
              AllOf(HasSubstr("unknown model 'cat'"), HasSubstr("nearest is 'car'")));
  ::setenv("ARBOX_MODEL_PATH", "models", 1);
  EXPECT_THAT(message_of([] { find_model("car"); }), HasSubstr("expected absolute folders"));
  ::unsetenv("ARBOX_MODEL_PATH");
  EXPECT_THAT(message_of([] { find_model("no/such.arbox"); }), HasSubstr("no such file"));
  EXPECT_THAT(message_of([&] { find_model(folder.path().string()); }), HasSubstr("directory"));
}

}  // namespace
}  // namespace arbox::io
