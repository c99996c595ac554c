#include "arbox/heads/codec_options.h"

#include "arbox/base/options.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"

namespace arbox::heads {
namespace {

/// The fields that every codec's options share.
template <class Options>
Options with_ranges(Options codec, const CodecOptions& options) {
  codec.order = options.order;
  codec.bins = options.bins;
  codec.size_low = options.size_low.value_or(codec.size_low);
  codec.size_high = options.size_high.value_or(codec.size_high);
  codec.center_low = options.center_low.value_or(codec.center_low);
  codec.center_high = options.center_high.value_or(codec.center_high);
  return codec;
}

YawCodecOptions upright(const YawCodecOptions& defaults, const CodecOptions& options) {
  YawCodecOptions codec = with_ranges(defaults, options);
  codec.full_turn = options.full_turn;
  codec.half_turn_equivalent = options.half_turn_equivalent;
  codec.quarter_turn_equivalent = options.quarter_turn_equivalent;
  return codec;
}

}  // namespace

std::shared_ptr<const BoxCodec> make_codec(const CodecOptions& options) {
  validate_options(options, "codec");
  if (options.kind == "quartile") {
    QuartileCodecOptions codec = with_ranges(QuartileCodecOptions(), options);
    codec.beta_high = options.beta_high;
    codec.equivalents = options.equivalents;
    return std::make_shared<QuartileCodec>(codec);
  }
  if (options.kind == "scaled") {
    return std::make_shared<ScaledCodec>(upright(ScaledCodec::defaults(), options),
                                         options.with_yaw);
  }
  return std::make_shared<ResidualCodec>(upright(ResidualCodec::defaults(), options));
}

}  // namespace arbox::heads
