#include "arbox/io/numpy_pickle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "made_pickles.h"
#include "support/refusal.h"

namespace arbox::io {
namespace {

using ::arbox::testing::refusal;
using namespace std::string_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NumpyInPickles : public ::testing::TestWithParam<int> {
 protected:
  PickleValue array(const char* name) const {
    return read_pickle(testing::made_pickle("arrays" + std::to_string(GetParam()) + ".pkl"))
        .at(name);
  }
  std::vector<double> numbers(const char* name) const {
    return numpy_array(array(name)).values<double>();
  }
  std::vector<std::size_t> shape(const char* name) const {
    return numpy_array(array(name)).shape();
  }
};
INSTANTIATE_TEST_SUITE_P(Protocols, NumpyInPickles, ::testing::Range(0, 6));

TEST_P(NumpyInPickles, GiveNumbers) {
  EXPECT_THAT(numbers("f4"), ElementsAre(1.5, -2, 3, 4));
  EXPECT_THAT(shape("f4"), ElementsAre(2, 2));
  EXPECT_EQ(numpy_array(array("f4")).header().type, NumberType::kFloat32);
  EXPECT_THAT(numbers("f8"), ElementsAre(1e-300));
  EXPECT_THAT(numbers("f2"), ElementsAre(0.5, -2));
  EXPECT_THAT(numbers("big"), ElementsAre(1, -2));
  EXPECT_THAT(numbers("i8"), ElementsAre(-5));
  EXPECT_THAT(numbers("u1"), ElementsAre(255));
  EXPECT_THAT(numbers("bool"), ElementsAre(1, 0));
  EXPECT_THAT(numbers("fortran"), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(shape("fortran"), ElementsAre(2, 3));
  EXPECT_THAT(shape("empty"), ElementsAre(0, 7));
  EXPECT_THAT(numbers("zero_d"), ElementsAre(2.5));
  EXPECT_THAT(shape("zero_d"), IsEmpty());
  EXPECT_THAT(numbers("step"), ElementsAre(0, 3, 6, 9));
  std::vector<double> large(100000);
  std::iota(large.begin(), large.end(), 0.0);
  EXPECT_EQ(numbers("large"), large);
}

TEST_P(NumpyInPickles, GiveScalars) {
  EXPECT_TRUE(is_numpy(array("scalar")));
  EXPECT_THAT(numbers("scalar"), ElementsAre(1.25));
  EXPECT_THAT(shape("scalar"), IsEmpty());
  EXPECT_THAT(numbers("integer"), ElementsAre(-9));
  EXPECT_THAT(numbers("flag"), ElementsAre(1));
}

TEST_P(NumpyInPickles, GiveTextAndObjects) {
  EXPECT_THAT(numpy_texts(array("texts")).values, ElementsAre("chair", "Vélo", ""));
  EXPECT_THAT(numpy_texts(array("byte_texts")).values, ElementsAre("ab", "c"));
  EXPECT_THAT(numpy_texts(array("object_texts")).values, ElementsAre("p", "qq"));
  const NumpyTexts fortran = numpy_texts(array("fortran_texts"));
  EXPECT_THAT(fortran.values, ElementsAre("a", "bcd", "e", "f"));
  EXPECT_THAT(fortran.shape, ElementsAre(2, 2));
  const NumpyObjects objects = numpy_objects(array("objects"));
  EXPECT_THAT(objects.shape, ElementsAre(3, 1));
  EXPECT_EQ(objects.values[0].at("a").integer(), 1);
  EXPECT_TRUE(objects.values[1].is_none());
}

TEST_P(NumpyInPickles, RefuseOtherElements) {
  EXPECT_THAT(refusal<FormatError>([&] { numpy_array(array("structured")); }),
              HasSubstr("structured arrays"));
  EXPECT_THAT(refusal<FormatError>([&] { numpy_array(array("complex")); }),
              HasSubstr("got one of '<c16'"));
  EXPECT_THAT(refusal<FormatError>([&] { numpy_array(array("texts")); }),
              HasSubstr("['texts']: expected"));
  EXPECT_THAT(refusal<FormatError>([&] { numpy_array(array("objects")); }), HasSubstr("'|O'"));
  EXPECT_THAT(refusal<FormatError>([&] { numpy_texts(array("f4")); }),
              HasSubstr("an array of text"));
  EXPECT_THAT(refusal<FormatError>([&] { numpy_objects(array("f4")); }),
              HasSubstr("an array of objects"));
}

TEST(NumpyPickle, ReadsNpyFilesOfObjectsAndText) {
  const auto bytes = [](const char* name) { return read_file(testing::made_pickle(name)); };
  const NumpyObjects scene = parse_npy_objects(bytes("scene.npy"), "scene.npy");
  EXPECT_THAT(scene.shape, IsEmpty());
  ASSERT_EQ(scene.values.size(), 1U);
  EXPECT_THAT(numpy_array(scene.values[0].at("boxes")).values<float>(),
              ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(numpy_texts(scene.values[0].at("names")).values, ElementsAre("a"));
  EXPECT_THAT(parse_npy_objects(bytes("objects.npy"), "o.npy").shape, ElementsAre(3, 1));
  EXPECT_THAT(parse_npy_texts(bytes("texts.npy"), "t.npy").values,
              ElementsAre("a", "bcd", "e", "f"));
  EXPECT_THAT(parse_npy_texts(bytes("byte_texts.npy"), "t.npy").values, ElementsAre("ab", "c"));
  EXPECT_THAT(refusal<FormatError>([&] { parse_npy_objects(bytes("numbers.npy"), "n.npy"); }),
              HasSubstr("n.npy: expected an array of objects, got one of '<f4'"));
  EXPECT_THAT(refusal<FormatError>([&] { parse_npy_texts(bytes("numbers.npy"), "n.npy"); }),
              HasSubstr("an array of text"));
  const std::string texts = bytes("texts.npy");
  EXPECT_THAT(
      refusal<FormatError>([&] { parse_npy_texts(texts.substr(0, texts.size() - 1), "t.npy"); }),
      HasSubstr("expected 48 bytes of data"));
}

/// The pickle of an array of `type`, `shape` and data, all as instructions.
std::string made_array(const std::string& type, const std::string& shape, const std::string& data) {
  return "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n(" + shape +
         "tcnumpy\ndtype\n(S'" + type + "'\nI0\nI1\ntR(I3\nS'<'\nNNNI-1\nI-1\nI0\ntbI00\n" + data +
         "tb.";
}

TEST(NumpyPickle, ShapesAreComparedWithTheData) {
  const auto parsed = [](const std::string& bytes) {
    return refusal<FormatError>([&] { numpy_array(parse_pickle(bytes, "a.pkl")); });
  };
  EXPECT_EQ(parsed(made_array("f4", "I2\n", "S'12345678'\n")), "no error");
  EXPECT_THAT(parsed(made_array("f4", "I3\n", "S'12345678'\n")),
              HasSubstr("expected 12 bytes of data for shape (3) of <f4, got 8"));
  EXPECT_THAT(parsed(made_array("f4", "I1\n", "S'12345678'\n")), HasSubstr("got 8 bytes"));
  EXPECT_THAT(parsed(made_array("f4", "I4611686018427387904\nI4611686018427387904\n", "S''\n")),
              HasSubstr("more than 2^63"));
  EXPECT_THAT(parsed(made_array("f4", "I-1\n", "S''\n")), HasSubstr("a number from 0, got -1"));
  EXPECT_THAT(parsed(made_array("f4", "N", "S''\n")), HasSubstr("an integer, got None"));
  EXPECT_THAT(parsed(made_array("f4", "I1\n", "N")), HasSubstr("expected bytes, got None"));
  EXPECT_THAT(parsed("N."), HasSubstr("a NumPy array, got None"));
  EXPECT_THAT(parsed("cnumpy.core.multiarray\n_reconstruct\n(tR."), HasSubstr("with its state"));
  const auto texts = [](const std::string& bytes) {
    return refusal<FormatError>([&] { numpy_texts(parse_pickle(bytes, "a.pkl")); });
  };
  EXPECT_THAT(texts(made_array("U0", "I1000000000000\n", "S''\n")), HasSubstr("an array of text"));
  EXPECT_THAT(texts(made_array("U1", "I1\n", "S'\\xff\\xff\\xff\\xff'\n")), HasSubstr("Unicode"));
  const auto objects = [](const std::string& bytes) {
    return refusal<FormatError>([&] { numpy_objects(parse_pickle(bytes, "a.pkl")); });
  };
  EXPECT_THAT(objects(made_array("O8", "I1000000000000\n", "(l")),
              HasSubstr("a list of 1000000000000 objects"));
}

}  // namespace
}  // namespace arbox::io
