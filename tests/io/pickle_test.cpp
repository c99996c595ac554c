#include "arbox/io/pickle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <cstdlib>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "made_pickles.h"
#include "support/refusal.h"

namespace arbox::io {
namespace {

using ::arbox::testing::refusal;
using namespace std::string_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string message_of(const std::string& bytes) {
  try {
    parse_pickle(bytes, "a.pkl");
  } catch (const FormatError& error) {
    return error.what();
  }
  return "no error";
}

class EveryProtocol : public ::testing::TestWithParam<int> {
 protected:
  PickleValue values() const {
    return read_pickle(testing::made_pickle("values" + std::to_string(GetParam()) + ".pkl"));
  }
};
INSTANTIATE_TEST_SUITE_P(Pickle, EveryProtocol, ::testing::Range(0, 6));

TEST_P(EveryProtocol, GivesPlainValues) {
  const PickleValue all = values();
  EXPECT_EQ(all.kind(), PickleKind::kDict);
  EXPECT_TRUE(all.at("none").is_none());
  EXPECT_TRUE(all.at("true").boolean());
  EXPECT_FALSE(all.at("false").boolean());
  std::vector<std::int64_t> integers;
  for (const auto& value : all.at("integers").elements()) integers.push_back(value.integer());
  EXPECT_THAT(integers,
              ElementsAre(0, 1, 255, 256, 65535, 65536, -1, -129, 2147483647, -2147483648,
                          std::int64_t(1) << 62, std::numeric_limits<std::int64_t>::min()));
  EXPECT_THAT(all.at("floats").numbers(),
              ElementsAre(0.0, -1.5, 1e300, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(all.at("text").text(), "Vélo \u4e16 \U0001f600\n\\");
  EXPECT_EQ(all.at("bytes").bytes(), "\x00\xff'\n\\"s);
  EXPECT_EQ(all.at("bytearray").bytes(), "ab\xff");
  const auto empty = all.at("empty").elements();
  EXPECT_EQ(empty[3].text(), "");
  EXPECT_EQ(empty[0].size() + empty[1].size() + empty[2].size(), 0U);
  EXPECT_EQ(empty[4].bytes(), "");
  EXPECT_EQ(all.at("long").numbers().size(), 3000U);
}

TEST_P(EveryProtocol, GivesContainers) {
  const PickleValue all = values();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(all.at("tuples")[i].kind(), PickleKind::kTuple);
    EXPECT_EQ(all.at("tuples")[i].size(), i + 1);
  }
  EXPECT_EQ(all.at("set").size(), 1U);
  EXPECT_EQ(all.at("set")[0].integer(), 7);
  EXPECT_EQ(all.at("frozenset").elements().at(0).integer(), 8);
  EXPECT_THAT(all.at("nested").numbers(), ElementsAre(1.0, 2.0, 3.0, 4.5));
  EXPECT_TRUE(all.at("shared")[0].same(all.at("shared")[1]));
  EXPECT_TRUE(all.at("recursive").same(all.at("recursive")[1]));
  EXPECT_FALSE(all.has("nothing"));
  EXPECT_EQ(all.key(0).text(), "none");
  EXPECT_EQ(all.size(), 20U);
}

TEST_P(EveryProtocol, ObjectsAreNamesAndArguments) {
  const PickleValue all = values();
  const PickleValue ordered = all.at("ordered");
  EXPECT_EQ(ordered.kind(), PickleKind::kObject);
  EXPECT_EQ(ordered.name(), "OrderedDict");
  EXPECT_EQ(ordered.key(0).text(), "b");
  EXPECT_EQ(ordered.at("a").integer(), 2);
  const PickleValue date = all.at("date");
  EXPECT_TRUE(date.is("datetime", "date"));
  EXPECT_EQ(date.arguments()[0].bytes(), "\x07\xe6\x0a\x17");
  EXPECT_EQ(all.at("global").kind(), PickleKind::kGlobal);
  EXPECT_TRUE(all.at("global").is("collections", "OrderedDict"));
}

TEST_P(EveryProtocol, MistakesNameThePlace) {
  const PickleValue all = values();
  EXPECT_THAT(refusal<FormatError>([&] { all.at("nested")[1][0].text(); }),
              AllOf(HasSubstr(".pkl['nested'][1][0]: expected text, got 3")));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("nests"); }),
              AllOf(HasSubstr("expected the key 'nests'"), HasSubstr("'nested'")));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("text").integer(); }), HasSubstr("got text 'V"));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("tuples")[9]; }),
              HasSubstr("at least 10 elements, got 4"));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("integers")[6].length(); }),
              HasSubstr("from 0, got -1"));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("date").numbers(); }),
              HasSubstr("object 'datetime.date'"));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("recursive").numbers(); }),
              HasSubstr("over and over"));
  EXPECT_THAT(refusal<FormatError>([&] { all.at("floats").key(0); }), HasSubstr("a dictionary"));
}

TEST_P(EveryProtocol, EveryTruncationIsAnError) {
  const std::string bytes =
      read_file(testing::made_pickle("values" + std::to_string(GetParam()) + ".pkl"));
  for (std::size_t length = 0; length < bytes.size(); length += length < 1500 ? 1 : 97) {
    EXPECT_NE(message_of(bytes.substr(0, length)), "no error") << length;
  }
}

TEST(Pickle, NothingIsRun) {
  const testing::TemporaryDirectory folder;
  const std::string file = (folder / "evil").string();
  for (const std::string& bytes :
       {"cos\nsystem\n(S'touch " + file + "'\ntR.", "(S'touch " + file + "'\nios\nsystem\n.",
        "(cos\nsystem\nS'touch " + file + "'\no.",
        "\x80\x04\x8c\x02os\x8c\x06system\x93\x8c"s + static_cast<char>(6 + file.size()) +
            "touch " + file + "\x85R."}) {
    const PickleValue value = parse_pickle(bytes, "evil.pkl");
    EXPECT_EQ(value.kind(), PickleKind::kObject);
    EXPECT_TRUE(value.is("os", "system"));
    EXPECT_EQ(value.arguments()[0].text(), "touch " + file);
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_THAT(refusal<FormatError>([&] { value.text(); }), HasSubstr("got object 'os.system'"));
  }
}

TEST(Pickle, ObjectsKeepWhatWouldBeDoneToThem) {
  const PickleValue value =
      parse_pickle("\x80\x04\x8c\x01m\x8c\x01n\x93)}\x8c\x03keyK\x05s\x92K\x01"s + "a(K\x02K\x03" +
                       "e" + "\x8c\x01kK\x04s}\x8c\x01zNsb.",
                   "a.pkl");
  EXPECT_TRUE(value.is("m", "n"));
  EXPECT_TRUE(value.callable().is(PickleKind::kGlobal));
  ASSERT_TRUE(value.named_arguments());
  EXPECT_EQ(value.named_arguments()->size(), 1U);
  EXPECT_EQ(value.items().size(), 3U);
  EXPECT_EQ(value.items()[2].integer(), 3);
  EXPECT_EQ(value.at("k").integer(), 4);
  ASSERT_TRUE(value.state());
  EXPECT_TRUE(value.state()->at("z").is_none());
}

TEST(Pickle, PersistentIdsAndBigIntegers) {
  const PickleValue value = parse_pickle(
      "\x80\x02(X\7\0\0\0storageK\5tQP7\n\x86\x8a\x0al\xfc\x9c\x46\xf9 j\xa8P\x19\x86."s, "a.pkl");
  EXPECT_EQ(value[0][0].id()[1].integer(), 5);
  EXPECT_EQ(value[0][1].id().text(), "7");
  EXPECT_EQ(value[1].kind(), PickleKind::kBigInteger);
  EXPECT_EQ(value[1].bytes(), "l\xfc\x9c\x46\xf9 j\xa8P\x19");
  EXPECT_THAT(refusal<FormatError>([&] { value[1].integer(); }), HasSubstr("got big integer"));
  EXPECT_THAT(message_of("L123456789012345678901234567890L\n."), HasSubstr("expected a number"));
}

TEST(Pickle, ReadsOnePickleAfterAnother) {
  const auto content = std::make_shared<const std::string>("K\1.K\2.rest");
  std::size_t begin = 0;
  EXPECT_EQ(parse_pickle(content, begin, "a").integer(), 1);
  EXPECT_EQ(begin, 3U);
  EXPECT_EQ(parse_pickle(content, begin, "a").integer(), 2);
  EXPECT_EQ(content->substr(begin), "rest");
  begin = 10;
  EXPECT_THROW(parse_pickle(content, begin, "a"), FormatError);
}

TEST(Pickle, RefusesWhatIsNoPickle) {
  EXPECT_THAT(message_of(""), HasSubstr("a.pkl: expected a pickle, got an empty file"));
  EXPECT_THAT(message_of("hello"), HasSubstr("a.pkl: byte 0: pickle: expected a value with"));
  EXPECT_THAT(message_of("\x80\x06."s), HasSubstr("protocol 0 to 5, got 6"));
  EXPECT_THAT(message_of("\xff"), HasSubstr("got byte 255"));
  EXPECT_THAT(message_of("."), HasSubstr("the stack, which is empty"));
  EXPECT_THAT(message_of("K\1(."), HasSubstr("the stack, which is empty"));
  EXPECT_THAT(message_of("t."), HasSubstr("which has none"));
  EXPECT_THAT(message_of("NNR."), HasSubstr("a tuple of arguments, got None"));
  EXPECT_THAT(message_of("NNa."), HasSubstr("a list, set or object to add to, got None"));
  EXPECT_THAT(message_of("]NNs."), HasSubstr("a dictionary or object to set items of, got list"));
  EXPECT_THAT(message_of("}(Nu."), HasSubstr("an odd number"));
  EXPECT_THAT(message_of("]Nb."), HasSubstr("an object to give a state to"));
  EXPECT_THAT(message_of("NN\x93."), HasSubstr("module and name as text"));
  EXPECT_THAT(message_of("h\7."), HasSubstr("the number 7"));
  EXPECT_THAT(message_of("p-1\n."), HasSubstr("stack, which is empty"));
  EXPECT_THAT(message_of("Np-1\n."), HasSubstr("expected a number, got '-1'"));
  EXPECT_THAT(message_of("S'a\n."), HasSubstr("Python's escapes"));
  EXPECT_THAT(message_of("V\\u12\n."), HasSubstr("Python's escapes"));
  EXPECT_THAT(message_of("\x82\1."), HasSubstr("registry of extensions"));
  EXPECT_THAT(message_of("\x97."), HasSubstr("buffers outside of the pickle"));
  EXPECT_THAT(message_of("I1"), HasSubstr("ends within it"));
}

TEST(Pickle, LengthsAreComparedWithTheFile) {
  EXPECT_THAT(message_of("X\xff\xff\xff\x7f"s), HasSubstr("expected 2147483647 bytes more"));
  EXPECT_THAT(message_of("\x8d\xff\xff\xff\xff\xff\xff\xff\xff"s),
              HasSubstr("18446744073709551615 bytes more, but the file ends after 0"));
  EXPECT_THAT(message_of("\x8e\0\0\0\0\0\0\0\x40"s), HasSubstr("4611686018427387904"));
  EXPECT_THAT(message_of("\x8b\xff\xff\xff\xff."s), HasSubstr("4294967295"));
  EXPECT_THAT(message_of("\x95\0\0\0\1\0\0\0\0N."s), HasSubstr("a frame of 16777216 bytes"));
  EXPECT_EQ(message_of("Nr\xff\xff\xff\xffj\xff\xff\xff\xff."s), "no error");
}

// What these would be in full has 2^60 elements, or a million levels.
TEST(Pickle, BombsStaySmall) {
  std::string doubling = "]q\0"s;
  for (int i = 0; i < 60; ++i)
    doubling += "0](h"s + static_cast<char>(i) + "h" + static_cast<char>(i) + "eq" +
                static_cast<char>(i + 1);
  const PickleValue bomb = parse_pickle(doubling + ".", "a.pkl");
  EXPECT_TRUE(bomb[0].same(bomb[1]));
  EXPECT_THAT(refusal<FormatError>([&] { bomb.numbers(); }), HasSubstr("over and over"));

  constexpr int kDepth = 1000000;
  std::string deep(kDepth, ']');
  deep.append(kDepth - 1, 'a');
  const PickleValue tower = parse_pickle(deep + ".", "a.pkl");
  EXPECT_EQ(tower.numbers().size(), 0U);

  std::string tuples = ")";
  for (int i = 0; i < kDepth; ++i) tuples += '\x85';
  EXPECT_EQ(parse_pickle(tuples + ".", "a.pkl").size(), 1U);
  EXPECT_EQ(message_of(std::string(kDepth, '(') + "N."), "no error");
}

std::string repeated(const std::string& first, const std::string& part) {
  constexpr std::size_t kSize = 1 << 20;
  std::string bytes = first;
  while (bytes.size() < kSize) bytes += part;
  return bytes + ".";
}

/// Largest memory of this process so far, bytes.
std::size_t peak_memory() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) << 10;
}

// Each in a process of its own, whose peak tells.
TEST(PickleDeathTest, MemoryIsAtMostAHundredTimesTheFile) {
  for (const std::string& bytes :
       {repeated("", "]"), repeated("", "}"), repeated("", "("), repeated("N", "2"),
        repeated("", "]\x94"), repeated(")", "2R"), repeated("N", "2\x85"), repeated("", "c\n\n"),
        repeated("", "I1\n"), repeated("", "]Na"), repeated("", "V\\u0041\n"),
        repeated("", "S''\n"), repeated("N", "(2o")}) {
    EXPECT_EXIT(
        {
          const std::size_t before = peak_memory();
          const std::string told = message_of(bytes);
          const std::size_t used = peak_memory() - before;
          std::exit(used < 110 * bytes.size() ? 0 : 1);
        },
        ::testing::ExitedWithCode(0), "")
        << bytes.substr(0, 10);
  }
}

// One dictionary of arguments that many calls share is kept once.
TEST(Pickle, SharedArgumentsAreNotCopied) {
  std::string bytes = "\x80\x04\x8c\x01m\x8c\x01n\x93\x94)\x94}\x94("s;
  for (int i = 0; i < 1000; ++i) bytes += "K\1N";
  bytes += "u0(";
  for (int i = 0; i < 1000; ++i) bytes += "h\0h\1h\2\x92"s;
  const PickleValue calls = parse_pickle(bytes + "l.", "a.pkl");
  EXPECT_EQ(calls.size(), 1000U);
  EXPECT_TRUE(calls[0].named_arguments()->same(*calls[999].named_arguments()));
}

}  // namespace
}  // namespace arbox::io
