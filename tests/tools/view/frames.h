// Reads the messages that pages get, for tests.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace scree::view {

template <class Number>
Number read_at(const std::string& bytes, std::size_t offset) {
  Number number{};
  EXPECT_LE(offset + sizeof number, bytes.size());
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

template <class Number>
std::vector<Number> take(const std::string& bytes, std::size_t& offset, std::size_t count) {
  std::vector<Number> numbers(count);
  EXPECT_LE(offset + count * sizeof(Number), bytes.size());
  std::memcpy(numbers.data(), bytes.data() + offset, count * sizeof(Number));
  offset += count * sizeof(Number);
  return numbers;
}

inline std::uint32_t kind_of(const std::string& message) { return read_at<std::uint32_t>(message, 0); }

struct ReadFrame {
  explicit ReadFrame(const std::string& bytes) {
    EXPECT_EQ(kind_of(bytes), 3u);
    track = read_at<std::uint32_t>(bytes, 4);
    step = read_at<double>(bytes, 8);
    roster = read_at<std::uint32_t>(bytes, 16);
    const auto n = read_at<std::uint32_t>(bytes, 20);
    const auto contact_count = read_at<std::uint32_t>(bytes, 24);
    const auto joint_count = read_at<std::uint32_t>(bytes, 28);
    shade = read_at<std::uint32_t>(bytes, 32);
    std::size_t offset = 40;
    numbers = take<std::uint32_t>(bytes, offset, n);
    positions = take<float>(bytes, offset, 3 * n);
    speeds = take<float>(bytes, offset, n);
    values = take<float>(bytes, offset, n);
    rotations = take<std::int16_t>(bytes, offset, 4 * n);
    awake = take<std::uint8_t>(bytes, offset, n);
    offset = (offset + 3) / 4 * 4;
    contacts = take<float>(bytes, offset, 12 * contact_count);
    joints = take<float>(bytes, offset, 12 * joint_count);
    if (read_at<std::uint32_t>(bytes, 36) != 0) energies = take<float>(bytes, offset, n);
    EXPECT_EQ(offset, bytes.size());
  }

  std::uint32_t track = 0, roster = 0, shade = 0;
  double step = 0.0;
  std::vector<std::uint32_t> numbers;
  std::vector<float> positions, speeds, values, contacts, joints, energies;
  std::vector<std::int16_t> rotations;
  std::vector<std::uint8_t> awake;
};

inline nlohmann::json head_of_news(const std::string& message) {
  EXPECT_EQ(kind_of(message), 1u);
  return nlohmann::json::parse(message.substr(8, read_at<std::uint32_t>(message, 4)));
}

}  // namespace scree::view
