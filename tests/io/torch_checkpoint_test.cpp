#include "arbox/io/torch_checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/numpy_pickle.h"
#include "support/program.h"
#include "support/refusal.h"

namespace arbox::io {
namespace {

using ::arbox::testing::refusal;
using namespace std::string_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The folder that make_checkpoints.py fills, once.
std::filesystem::path made(const std::string& name) {
  static const testing::TemporaryDirectory folder;
  static const testing::RunResult result =
      testing::run("/usr/bin/python3", {ARBOX_MAKE_CHECKPOINTS, folder.path().string()});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return folder / name;
}

std::string refused(const std::string& bytes) {
  return refusal<FormatError>([&] {
    const auto checkpoint = parse_torch_checkpoint(bytes, "a.pth");
    checkpoint.tensors(checkpoint.value().at("model_state"));
  });
}

class TorchFormats : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Checkpoint, TorchFormats, ::testing::Values("zip.pth", "legacy.pth"));

TEST_P(TorchFormats, GivesEveryTensor) {
  const TorchCheckpoint checkpoint = read_torch_checkpoint(made(GetParam()));
  const auto tensors = checkpoint.tensors(checkpoint.value().at("model_state"));
  const auto numbers = [&](const char* name) { return tensors.at(name).values<double>(); };
  std::vector<double> rising(24);
  std::iota(rising.begin(), rising.end(), 0.0);
  EXPECT_EQ(numbers("plain"), rising);
  EXPECT_THAT(tensors.at("plain").shape, ElementsAre(2, 3, 4));
  EXPECT_THAT(tensors.at("transposed").shape, ElementsAre(6, 4));
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_EQ(numbers("transposed")[i], static_cast<double>(i % 4 * 6 + i / 4));
  }
  EXPECT_THAT(numbers("part"), ElementsAre(5, 8, 11, 14));
  EXPECT_THAT(numbers("expanded"), ElementsAre(7, 7, 7));
  EXPECT_THAT(numbers("scalar"), ElementsAre(2.5));
  EXPECT_THAT(tensors.at("scalar").shape, IsEmpty());
  EXPECT_THAT(tensors.at("empty").shape, ElementsAre(0, 4));
  EXPECT_THAT(numbers("half"), ElementsAre(0.5, -2));
  EXPECT_EQ(tensors.at("half").type, NumberType::kFloat16);
  EXPECT_THAT(numbers("bfloat16"), ElementsAre(1.5, ::testing::DoubleNear(-3e38, 1e36), 0));
  EXPECT_EQ(tensors.at("bfloat16").type, NumberType::kFloat32);
  EXPECT_THAT(numbers("double"), ElementsAre(1e-300));
  EXPECT_THAT(tensors.at("long").values<std::int64_t>(), ElementsAre(-5, std::int64_t(1) << 40));
  EXPECT_THAT(numbers("int"), ElementsAre(-7));
  EXPECT_THAT(numbers("short"), ElementsAre(-8));
  EXPECT_THAT(numbers("char"), ElementsAre(-9));
  EXPECT_THAT(numbers("byte"), ElementsAre(255));
  EXPECT_THAT(numbers("bool"), ElementsAre(1, 0));
  EXPECT_EQ(tensors.at("bool").type, NumberType::kBool);
  EXPECT_THAT(numbers("parameter"), ElementsAre(1, 1, 1, 1));
  EXPECT_EQ(tensors.size(), 16U);
}

TEST_P(TorchFormats, GivesOtherValues) {
  const PickleValue value = read_torch_checkpoint(made(GetParam())).value();
  EXPECT_EQ(value.at("epoch").integer(), 80);
  EXPECT_THAT(numpy_array(value.at("it")).values<std::int64_t>(), ElementsAre(3));
  EXPECT_EQ(value.at("version").text(), "pcdet+0.5.2");
  EXPECT_FALSE(is_torch_tensor(value.at("version")));
  EXPECT_EQ(value.at("optimizer_state").at("param_groups")[0].at("lr").number(), 1e-3);
}

TEST_P(TorchFormats, RunsNothing) {
  const TorchCheckpoint checkpoint = read_torch_checkpoint(made("evil_"s + GetParam()));
  EXPECT_EQ(checkpoint.value().at("evil").name(), "system");
  EXPECT_EQ(checkpoint.tensors(checkpoint.value().at("model_state")).size(), 16U);
  EXPECT_FALSE(std::filesystem::exists(made("evil")));
}

TEST_P(TorchFormats, RefusesTypesThatRecordsLack) {
  EXPECT_THAT(refusal<FormatError>([] {
                const auto checkpoint = read_torch_checkpoint(made("complex_"s + GetParam()));
                checkpoint.tensor(checkpoint.value().at("c"));
              }),
              AllOf(HasSubstr("a storage of bools, integers or floats"),
                    HasSubstr("torch.ComplexFloatStorage")));
}

TEST_P(TorchFormats, EveryTruncationIsAnError) {
  const std::string bytes = read_file(made(GetParam()));
  for (std::size_t length = 0; length < bytes.size(); length += 7) {
    EXPECT_NE(refused(bytes.substr(0, length)), "no error") << length;
  }
}

TEST_P(TorchFormats, DamageNeverCrashes) {
  const std::string bytes = read_file(made(GetParam()));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
    static_cast<void>(refused(damaged));
  }
}

TEST(TorchCheckpoint, RefusesOtherFiles) {
  EXPECT_THAT(refused(""), HasSubstr("a.pth: expected a PyTorch checkpoint, got an empty file"));
  EXPECT_THAT(refused("PK nothing"), HasSubstr("expected a PyTorch checkpoint (zip archive)"));
  EXPECT_THAT(refused("K\1."), HasSubstr("a pickle of something else"));
  EXPECT_THAT(refused("torch"), HasSubstr("pickle: "));
  EXPECT_THAT(refused(read_file(made("script.pth"))), HasSubstr("a TorchScript module"));
  EXPECT_THAT(refused(read_file(made("no_value.pth"))), HasSubstr("without data.pkl"));
}

TEST(TorchCheckpoint, RefusesArchivesWithHoles) {
  EXPECT_THAT(refused(read_file(made("missing_storage.pth"))),
              AllOf(HasSubstr("['model_state']"), HasSubstr("'zip/data/0', which is missing")));
  EXPECT_THAT(refused(read_file(made("short_storage.pth"))),
              HasSubstr("within their storage of 92 bytes"));
  EXPECT_THAT(refused(read_file(made("big_endian.pth"))), HasSubstr("little-endian"));
  EXPECT_THAT(refused(read_file(made("bomb.pth"))), HasSubstr("unpacks to more than the limit"));
}

/// A stream with one storage of floats and a tensor of that layout.
std::string made_stream(const std::string& offset, const std::string& shape,
                        const std::string& strides, unsigned char floats = 4) {
  const std::string magic = "\x80\x02\x8a\nl\xfc\x9c\x46\xf9 j\xa8P\x19.";
  const std::string tensor =
      "ctorch._utils\n_rebuild_tensor_v2\n((U\7storagectorch\nFloatStorage\n"
      "U\1"
      "0U\3cpuK\4NtQ" +
      offset + "(" + shape + "t(" + strides + "tI00\n}tR";
  return magic + "\x80\x02M\xe9\x03." + "\x80\x02}U\x0dlittle_endian\x88s." +
         "\x80\x02}U\x0bmodel_state}U\1x" + tensor + "ss." +
         "\x80\x02(U\1"
         "0l." +
         std::string(1, static_cast<char>(floats)) + std::string(7, '\0') +
         std::string(4 * floats, 'x');
}

TEST(TorchCheckpoint, LayoutsAreComparedWithTheStorage) {
  EXPECT_EQ(refused(made_stream("K\0"s, "K\2K\2", "K\2K\1")), "no error");
  EXPECT_EQ(refused(made_stream("K\1", "K\3", "K\1")), "no error");
  EXPECT_THAT(refused(made_stream("K\1", "K\4", "K\1")), HasSubstr("some beyond"));
  EXPECT_THAT(refused(made_stream("K\0"s, "K\2", "K\4")), HasSubstr("some beyond"));
  EXPECT_THAT(refused(made_stream("J\xff\xff\xff\xff", "K\1", "K\1")), HasSubstr("got -1"));
  EXPECT_THAT(refused(made_stream("K\0"s, "K\1", "")), HasSubstr("a stride for each axis"));
  const std::string huge = "\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f";
  EXPECT_THAT(refused(made_stream(huge, "K\1", "K\1")), HasSubstr("some beyond"));
  EXPECT_THAT(refused(made_stream("K\0"s, "K\2K\2", huge + huge)), HasSubstr("some beyond"));
  EXPECT_THAT(refused(made_stream("K\0"s, huge + "K\2", "K\0K\0"s)), HasSubstr("more than 2^63"));
  EXPECT_THAT(refused(made_stream("K\0"s, "M\xff\xff", "K\0"s)),
              HasSubstr("expected 262140 bytes of data"));
  const std::string good = made_stream("K\0"s, "K\4", "K\1");
  EXPECT_THAT(refused(good.substr(0, good.size() - 1)), HasSubstr("ends within storage '0'"));
  EXPECT_THAT(refused(good.substr(0, good.size() - 20)), HasSubstr("ends within storage '0'"));
}

// Many names for one large tensor would be as many copies.
TEST(TorchCheckpoint, RefusesCopiesWithoutNumber) {
  std::string bytes = made_stream("K\0"s, "K\xc8", "K\1", 200);
  const std::size_t end = bytes.find("Rss.");
  std::string more = "R\x94";
  for (int i = 0; i < 200; ++i) {
    more += "sU\2"s + static_cast<char>('a' + i % 16) + static_cast<char>('a' + i / 16) + "h\0"s;
  }
  bytes.replace(end, 1, more);
  EXPECT_THAT(refused(bytes), HasSubstr("not far larger than the file"));
}

}  // namespace
}  // namespace arbox::io
