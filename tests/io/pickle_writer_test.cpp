#include "arbox/io/pickle_writer.h"

#include <gtest/gtest.h>

#include "arbox/io/file.h"
#include "arbox/io/numpy_pickle.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox {
namespace {

using io::PickleWriter;
using testing::expect_refusal;
using testing::TemporaryDirectory;

std::string made_values() {
  PickleWriter pickle;
  pickle.begin_dict();
  pickle.text("plain"), pickle.begin_list();
  pickle.none(), pickle.boolean(true), pickle.boolean(false);
  for (const std::int64_t number : {0L, 255L, 256L, -1L, 2147483647L, -2147483648L, 1L << 40}) {
    pickle.integer(number);
  }
  pickle.number(-0.1), pickle.text("Vélo \xF0\x9F\x98\x80"), pickle.text("a\xFF\xC3"),
      pickle.bytes(std::string("\0\xFF", 2));
  pickle.end();
  const double numbers[] = {1, 2, 3, 4, 5, 6};
  pickle.text("rows"), pickle.rows(numbers, 3);
  pickle.text("empty"), pickle.begin_dict(), pickle.end();
  pickle.text("f8"), pickle.array<double>(numbers, {2, 3});
  const float narrow[] = {0.5F, -2.0F};
  pickle.text("f4"), pickle.array<float>(narrow, {2, 1});
  const std::int64_t wide[] = {-5, 1L << 40};
  pickle.text("i8"), pickle.array<std::int64_t>(wide, {2});
  pickle.text("none"), pickle.array<double>({}, {0, 7});
  pickle.text("flags"), pickle.array(io::NumberType::kBool, {2}, std::string("\1\0", 2));
  const std::string words[] = {"chair", "Vélo", ""};
  pickle.text("texts"), pickle.texts(words);
  pickle.end();
  return std::move(pickle).finish();
}

TEST(PickleWriter, PythonReadsWhatWasWritten) {
  const TemporaryDirectory folder;
  folder.write("a.pkl", made_values());
  PickleWriter object;
  object.begin_object_array(), object.begin_dict();
  object.text("k"), object.integer(7), object.end(), object.end();
  folder.write("o.npy", io::encode_npy_object(std::move(object).finish()));
  const auto checked = testing::run("/usr/bin/python3", {"-c", R"(
import pickle, sys, numpy as np
d = pickle.load(open(sys.argv[1] + '/a.pkl', 'rb'))
assert d['plain'] == [None, True, False, 0, 255, 256, -1, 2**31 - 1, -2**31, 2**40, -0.1,
                      'V\u00e9lo \U0001F600', 'a\ufffd\ufffd', b'\0\xff'], d['plain']
assert d['rows'] == [[1, 2, 3], [4, 5, 6]] and d['empty'] == {}
assert d['f8'].dtype == np.float64 and (d['f8'] == [[1, 2, 3], [4, 5, 6]]).all()
assert d['f4'].dtype == np.float32 and (d['f4'] == [[0.5], [-2]]).all()
assert d['i8'].tolist() == [-5, 2**40] and d['none'].shape == (0, 7)
assert d['flags'].dtype == bool and d['flags'].tolist() == [True, False]
assert d['texts'].tolist() == ['chair', 'V\u00e9lo', ''], d['texts']
assert pickle.loads(pickle.dumps(d)).keys() == d.keys()
assert np.load(sys.argv[1] + '/o.npy', allow_pickle=True).item() == {'k': 7}
)",
                                                         folder.path().string()});
  EXPECT_EQ(checked.exit_code, 0) << checked.errors;
}

TEST(PickleWriter, OwnReaderReadsWhatWasWritten) {
  const auto value = io::parse_pickle(made_values(), "a");
  EXPECT_EQ(value.at("plain")[9].integer(), 1L << 40);
  EXPECT_EQ(value.at("plain")[10].number(), -0.1);
  EXPECT_EQ(value.at("rows").numbers(), (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(io::numpy_array(value.at("f8")).shape(), (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(io::numpy_array(value.at("i8")).values<std::int64_t>()[1], 1L << 40);
  EXPECT_EQ(io::numpy_texts(value.at("texts")).values,
            (std::vector<std::string>{"chair", "Vélo", ""}));
}

TEST(PickleWriter, RefusesWhatIsNotWhole) {
  expect_refusal([] { PickleWriter().finish(); }, {"one value"});
  expect_refusal(
      [] {
        PickleWriter pickle;
        pickle.begin_dict(), pickle.text("a"), pickle.end();
      },
      {"key that has no value"});
  expect_refusal(
      [] {
        PickleWriter pickle;
        pickle.begin_list();
        std::move(pickle).finish();
      },
      {"ended"});
  expect_refusal([] { PickleWriter().end(); }, {"nothing to end"});
  expect_refusal(
      [] {
        PickleWriter pickle;
        pickle.begin_object_array(), pickle.end();
      },
      {"one object"});
  expect_refusal(
      [] {
        const double one = 1;
        PickleWriter().array<double>({&one, 1}, {2});
      },
      {"do not fill"});
}

}  // namespace
}  // namespace arbox
