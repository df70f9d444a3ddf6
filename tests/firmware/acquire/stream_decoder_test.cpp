#include "firmware/acquire/stream_decoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "firmware/acquire/node_clock.hpp"
#include "tests/firmware/acquire/stream_frames.hpp"

namespace spindle_twin::firmware {
namespace acquire_stream_decoder_test {

using Bytes = std::vector<std::uint8_t>;

/// What comes of the bytes, fed in pieces of at most `piece`: the first value of each message.
std::vector<float> decoded(StreamDecoder& decoder, const Bytes& bytes, std::size_t piece = 5000) {
  std::vector<float> values;
  spindle_twin_stream_Readings message = spindle_twin_stream_Readings_init_zero;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto room = decoder.room();
    const std::size_t count = std::min({piece, room.size(), bytes.size() - at});
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), count, room.begin());
    decoder.received(count);
    at += count;
    while (decoder.next(message)) values.push_back(message.readings_count > 0 ? message.readings[0].value : -1.0F);
  }
  return values;
}

struct Stream {
  node sender{};
  Bytes bytes;
  Bytes last;
  void frame(float value) {
    last = frames::frame_of(sender, 1000, {value, 2.0F});
    bytes.insert(bytes.end(), last.begin(), last.end());
  }
};

TEST(StreamDecoder, its_checksum_is_that_of_ethernet) {
  const std::string digits = "123456789";
  EXPECT_EQ(crc32(Bytes(digits.begin(), digits.end())), 0xCBF43926U);
}

TEST(StreamDecoder, takes_every_frame_whatever_the_pieces_it_comes_in) {
  Stream stream;
  for (const float value : {1.0F, 2.0F, 3.0F}) stream.frame(value);
  for (std::size_t piece = 1; piece <= stream.bytes.size(); ++piece) {
    StreamDecoder decoder;
    EXPECT_EQ(decoded(decoder, stream.bytes, piece), (std::vector<float>{1.0F, 2.0F, 3.0F})) << piece;
    EXPECT_EQ(decoder.refused(), 0U);
    EXPECT_FALSE(decoder.has_part());
  }
}

TEST(StreamDecoder, a_frame_with_any_one_bit_flipped_is_refused_and_the_others_are_taken) {
  Stream before, stream;
  before.frame(1.0F);
  const std::size_t bits = 8 * before.bytes.size();
  for (std::size_t bit = 0; bit < bits; ++bit) {
    Stream all;
    all.frame(1.0F);
    all.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    for (int more = 0; more < 100; ++more) all.frame(static_cast<float>(more));
    StreamDecoder decoder;
    const std::vector<float> values = decoded(decoder, all.bytes);
    EXPECT_EQ(decoder.refused(), 1U) << bit;
    EXPECT_EQ(values.size(), 100U) << bit;
    EXPECT_EQ(values.front(), 0.0F) << bit;
  }
}

TEST(StreamDecoder, a_frame_that_is_cut_anywhere_is_refused_and_the_next_ones_are_taken) {
  Stream first;
  first.frame(1.0F);
  for (std::size_t left = 1; left < first.bytes.size(); ++left) {
    Stream all;
    all.frame(1.0F);
    all.bytes.resize(left);
    for (int more = 0; more < 100; ++more) all.frame(static_cast<float>(more));
    StreamDecoder decoder;
    EXPECT_EQ(decoded(decoder, all.bytes).size(), 100U) << left;
    EXPECT_EQ(decoder.refused(), 1U) << left;
  }
}

TEST(StreamDecoder, a_frame_that_comes_again_or_late_is_refused) {
  Stream stream;
  stream.frame(1.0F);
  const Bytes first = stream.last;
  stream.bytes.insert(stream.bytes.end(), first.begin(), first.end());
  stream.frame(2.0F);
  stream.frame(3.0F);
  stream.bytes.insert(stream.bytes.end(), first.begin(), first.end());
  stream.frame(4.0F);
  StreamDecoder decoder;
  EXPECT_EQ(decoded(decoder, stream.bytes), (std::vector<float>{1.0F, 2.0F, 3.0F, 4.0F}));
  EXPECT_EQ(decoder.refused(), 2U);
}

TEST(StreamDecoder, the_sequence_wraps) {
  Stream stream;
  stream.sender.sequence = 0xFFFFFFFDU;
  for (int i = 0; i < 5; ++i) stream.frame(static_cast<float>(i));
  StreamDecoder decoder;
  EXPECT_EQ(decoded(decoder, stream.bytes).size(), 5U);
  EXPECT_EQ(decoder.refused(), 0U);
}

TEST(StreamDecoder, a_frame_that_never_becomes_whole_is_given_up_for_what_follows_it) {
  Stream stream;
  stream.frame(1.0F);
  stream.bytes[4] = 7;  // 1792 bytes more than there are
  stream.frame(2.0F);
  StreamDecoder decoder;
  EXPECT_TRUE(decoded(decoder, stream.bytes).empty()) << "it waits for the rest";
  EXPECT_TRUE(decoder.has_part());
  decoder.give_up();
  spindle_twin_stream_Readings message = spindle_twin_stream_Readings_init_zero;
  ASSERT_TRUE(decoder.next(message));
  EXPECT_EQ(message.readings[0].value, 2.0F);
  EXPECT_EQ(decoder.refused(), 1U);
}

TEST(StreamDecoder, a_full_frame_of_the_node_fits) {
  node sender{};
  for (std::uint32_t i = 0; node_add(&sender, 65535, 1e30F, 0xFFFFFFFFU); ++i) ASSERT_LT(i, 41U);
  for (std::uint32_t i = 0; node_add_fast(&sender, 65535, 1e30F, 0xFFFFFFFFU); ++i) ASSERT_LT(i, 257U);
  Bytes frame(NODE_FRAME_ROOM);
  frame.resize(node_frame(&sender, 0xFFFFFFFFU, frame.data()));
  ASSERT_GT(frame.size(), 1000U);
  StreamDecoder decoder;
  EXPECT_EQ(decoded(decoder, frame), (std::vector<float>{1e30F}));
}

TEST(StreamDecoder, noise_is_refused_and_a_frame_behind_it_is_found) {
  std::mt19937 random(1);
  Stream stream;
  for (int i = 0; i < 20000; ++i) stream.bytes.push_back(static_cast<std::uint8_t>(random()));
  for (int i = 0; i < 300; ++i) stream.frame(5.0F);
  StreamDecoder decoder;
  const std::vector<float> values = decoded(decoder, stream.bytes, 100);
  EXPECT_GE(decoder.refused(), 1U);
  EXPECT_EQ(values.back(), 5.0F);
  EXPECT_GT(values.size(), 200U);
}

TEST(StreamDecoder, a_length_of_nothing_or_of_more_than_2048_bytes_is_refused_as_soon_as_it_is_read) {
  for (const auto& [length, refused] : {std::pair{0, 1U}, {1, 0U}, {2048, 0U}, {2049, 1U}}) {
    StreamDecoder decoder;
    const Bytes header{'S', 'T', 1, 0, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length & 255),
                       0,   0,   0, 1};
    EXPECT_TRUE(decoded(decoder, header).empty());
    EXPECT_EQ(decoder.refused(), refused) << length;
    EXPECT_EQ(decoder.has_part(), refused == 0) << length;
  }
}

/// Frames each second that take a second to come, behind one that took no time.
TEST(NodeClock, the_quickest_frame_counts_for_ten_seconds_and_those_of_the_ten_behind) {
  constexpr std::int64_t ms = 1'000'000;
  NodeClock clock;
  EXPECT_EQ(clock.made_ns(0, 50'000 * ms), 50'000 * ms);
  for (std::uint32_t k = 1; k <= 25; ++k) {
    const std::int64_t received_ns = (50'000 + 1000 * k) * ms;
    EXPECT_EQ(clock.made_ns(1000 * k - 1000, received_ns), received_ns - (k < 20 ? 1000 * ms : 0)) << k;
  }
}

TEST(NodeClock, behind_twenty_seconds_of_silence_its_clock_is_a_new_one) {
  constexpr std::int64_t ms = 1'000'000;
  for (const std::int64_t silence_ms : {19'999, 20'000}) {
    NodeClock clock;
    clock.made_ns(100, 50'000 * ms);
    const std::int64_t received_ns = (50'000 + silence_ms) * ms;
    const auto says_ms = static_cast<std::uint32_t>(100 + silence_ms - 5000);
    EXPECT_EQ(clock.made_ns(says_ms, received_ns), received_ns - (silence_ms < 20'000 ? 5000 * ms : 0)) << silence_ms;
  }
}

TEST(NodeClock, a_frame_that_was_held_up_is_as_old_as_it_is) {
  constexpr std::int64_t ms = 1'000'000;
  NodeClock clock;
  for (std::uint32_t t = 0; t < 5000; t += 100) {
    EXPECT_EQ(clock.made_ns(t - 2000U, (70'000 + t + 3) * ms), (70'003 + t) * ms)
        << "its clock starts anywhere and wraps";
  }
  EXPECT_EQ(clock.made_ns(5000U - 2000U, (75'000 + 4000) * ms), 75'003 * ms) << "4 s on the way";
}

TEST(NodeClock, drift_and_sleep_of_a_nodes_clock_are_forgotten) {
  constexpr std::int64_t ms = 1'000'000;
  NodeClock clock;
  std::int64_t at_ms = 1;
  for (std::uint32_t t = 0; t < 100'000; t += 100, at_ms += 101) clock.made_ns(t, at_ms * ms);
  EXPECT_LT(at_ms * ms - clock.made_ns(100'000, at_ms * ms), 250 * ms) << "1 % slow for 100 s";
  at_ms += 3'600'000;  // it slept for an hour
  for (std::uint32_t t = 100'100; t < 130'000; t += 100, at_ms += 100) clock.made_ns(t, at_ms * ms);
  EXPECT_LT(at_ms * ms - clock.made_ns(130'000, at_ms * ms), 250 * ms);
}

}  // namespace acquire_stream_decoder_test
}  // namespace spindle_twin::firmware
