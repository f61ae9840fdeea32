// Laws of the head and the chunks of a recording: they are read as they were written, and changed ones are
// refused. tests/parallel/recording has the laws of whole files.
#include <core/state/recording_format/recording_chunks.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr ChunkKind kKinds[] = {ChunkKind::hulls, ChunkKind::keyframe, ChunkKind::restored, ChunkKind::calls,
                                ChunkKind::end,   ChunkKind::meshes,   ChunkKind::part};

Bytes copy_of(std::span<const std::byte> bytes) { return Bytes(bytes.begin(), bytes.end()); }

Bytes noise(std::size_t count) {
  std::mt19937 random(11);
  Bytes bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xff);
  return bytes;
}
// As compressible as the rows of a state: few different values.
Bytes rows(std::size_t count) {
  Bytes bytes = noise(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] &= i % 4 == 0 ? std::byte{3} : std::byte{};
  return bytes;
}

struct Chunk {
  Bytes head, stored;
};
Chunk packed(ChunkPacker& packer, const ChunkHead& head, std::span<const std::byte> content) {
  const ChunkPacker::Packed chunk = packer.pack(head, content);
  return {copy_of(chunk.head), copy_of(chunk.stored)};
}
Chunk packed(const ChunkHead& head, std::span<const std::byte> content) {
  ChunkPacker packer(1);
  return packed(packer, head, content);
}

// A chunk's head in the order that recording_chunks.h states, with the right checksum.
Bytes sealed(const ChunkHead& head, std::uint16_t zero = 0) {
  ByteWriter writer;
  writer.put(kChunkMarker);
  writer.put(static_cast<std::uint8_t>(head.kind));
  writer.put(head.flags);
  writer.put(zero);
  writer.put(head.step);
  writer.put(head.steps);
  writer.put(head.count);
  writer.put(head.content_bytes);
  writer.put(head.stored_bytes);
  writer.put(head.stored_hash);
  writer.put(hash_of_bytes(writer.bytes()));
  return writer.take();
}

template <class Work>
void expect_refused(Work&& work, std::size_t offset, const std::string& reason) {
  try {
    work();
  } catch (const RefusedBytes& refused) {
    EXPECT_EQ(refused.offset, offset);
    EXPECT_EQ(refused.reason, reason);
    return;
  }
  ADD_FAILURE() << "not refused: " << reason;
}
template <class Work>
bool is_refused(Work&& work) {
  try {
    work();
  } catch (const RefusedBytes&) {
    return true;
  }
  return false;
}
void expect_head_refused(const Bytes& head, std::size_t offset, const std::string& reason) {
  expect_refused([&] { read_chunk_head(head); }, offset, reason);
}
constexpr std::size_t kFlagsOffset = 5, kStoredBytesOffset = 40, kStoredHashOffset = 48, kHeadHashOffset = 56;
constexpr const char* kWrongSize = "the chunk has a wrong number of bytes";

// Calls visit(changed, byte) with each bit of the bytes changed in turn.
template <class Visit>
void for_each_changed_bit(Bytes bytes, Visit&& visit) {
  for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      bytes[byte] ^= static_cast<std::byte>(1u << bit);
      visit(std::as_const(bytes), byte);
      bytes[byte] ^= static_cast<std::byte>(1u << bit);
    }
  }
}

TEST(RecordingChunks, UnpackToWhatWasPacked) {
  for (const int level : {1, 19}) {
    ChunkPacker packer(level);  // one for all: it keeps the memory of the chunk before
    for (const ChunkKind kind : kKinds) {
      for (const std::size_t size : {0u, 1u, 127u, 128u, 5000u, 300'000u, 40u}) {
        for (const Bytes& content : {noise(size), rows(size), Bytes(size)}) {
          const ChunkHead given{
              .kind = kind, .flags = kChunkMayBeSkipped, .step = 1ull << 40, .steps = 7, .count = 1ull << 33};
          const Chunk chunk = packed(packer, given, content);
          const ChunkHead head = read_chunk_head(chunk.head);
          EXPECT_EQ(head.kind, kind);
          EXPECT_EQ(head.flags & kChunkMayBeSkipped, kChunkMayBeSkipped);
          EXPECT_EQ(head.step, given.step);
          EXPECT_EQ(head.steps, given.steps);
          EXPECT_EQ(head.count, given.count);
          ASSERT_EQ(head.content_bytes, content.size());
          ASSERT_EQ(head.stored_bytes, chunk.stored.size());
          EXPECT_EQ(unpack_chunk(head, chunk.stored), content);
        }
      }
    }
  }
}

TEST(RecordingChunks, WhatCanBeCompressedIsAndOtherContentIsStoredAsItIs) {
  const auto is_compressed = [](const Bytes& content) {
    const Chunk chunk = packed({.kind = ChunkKind::calls}, content);
    const bool compressed = (read_chunk_head(chunk.head).flags & kChunkCompressed) != 0;
    EXPECT_TRUE(compressed ? chunk.stored.size() < content.size() : chunk.stored == content);
    return compressed;
  };
  EXPECT_TRUE(is_compressed(rows(5000)));
  EXPECT_TRUE(is_compressed(Bytes(128)));
  EXPECT_FALSE(is_compressed(Bytes(127)));  // not worth a frame
  EXPECT_FALSE(is_compressed(noise(5000)));
  EXPECT_FALSE(is_compressed({}));
}

TEST(RecordingChunks, HeadsHaveTheStatedLayout) {
  for (const Bytes& content : {noise(5000), rows(5000)}) {
    const Chunk chunk = packed({.kind = ChunkKind::keyframe, .step = 3, .steps = 4, .count = 5}, content);
    EXPECT_EQ(chunk.head.size(), kChunkHeadBytes);
    const ChunkHead head = read_chunk_head(chunk.head);
    EXPECT_EQ(head.stored_hash, hash_of_bytes(chunk.stored));
    EXPECT_EQ(sealed(head), chunk.head);
  }
}

TEST(RecordingChunks, AHeadWithAnyBitChangedIsRefused) {
  const Chunk chunk = packed({.kind = ChunkKind::calls, .step = 3, .steps = 4, .count = 5}, rows(5000));
  for_each_changed_bit(chunk.head, [](const Bytes& changed, std::size_t byte) {
    if (byte < sizeof kChunkMarker) {
      expect_head_refused(changed, 0, "no chunk begins here");
    } else {
      expect_head_refused(changed, kHeadHashOffset, "the checksum of the chunk's head is wrong");
    }
  });
}

TEST(RecordingChunks, AHeadThatEndsTooEarlyIsRefused) {
  const Chunk chunk = packed({.kind = ChunkKind::calls}, rows(5000));
  for (std::size_t length = 0; length < kChunkHeadBytes; ++length) {
    const Bytes cut = copy_of(std::span(chunk.head).first(length));
    expect_head_refused(cut, length, "the chunk ends too early");
  }
}

TEST(RecordingChunks, StoredBytesWithAnyBitChangedAreRefused) {
  for (const Bytes& content : {noise(500), rows(500)}) {
    const Chunk chunk = packed({.kind = ChunkKind::calls}, content);
    const ChunkHead head = read_chunk_head(chunk.head);
    for_each_changed_bit(chunk.stored, [&](const Bytes& changed, std::size_t) {
      expect_refused([&] { unpack_chunk(head, changed); }, kStoredHashOffset,
                     "the checksum of the chunk's bytes is wrong");
    });
  }
}

TEST(RecordingChunks, StoredBytesOfAnotherLengthAreRefused) {
  for (const Bytes& content : {noise(500), rows(500)}) {
    const Chunk chunk = packed({.kind = ChunkKind::calls}, content);
    const ChunkHead head = read_chunk_head(chunk.head);
    for (std::size_t length = 0; length < chunk.stored.size() + 3; ++length) {
      if (length == chunk.stored.size()) continue;
      Bytes other = chunk.stored;
      other.resize(length);
      expect_refused([&] { unpack_chunk(head, other); }, kStoredBytesOffset, "the chunk ends too early");
    }
  }
}

// With right checksums: bytes that were made on purpose.
TEST(RecordingChunks, CompressedBytesThatDoNotHoldTheContentAreRefused) {
  const Chunk sound = packed({.kind = ChunkKind::calls}, rows(5000));
  const Chunk other = packed({.kind = ChunkKind::calls}, rows(4999));
  const auto unpack = [&](Bytes stored) {
    ChunkHead head = read_chunk_head(sound.head);
    head.stored_bytes = stored.size();
    head.stored_hash = hash_of_bytes(stored);
    return unpack_chunk(head, std::move(stored));
  };
  EXPECT_EQ(unpack(sound.stored), rows(5000));
  const char* no_content = "the chunk's bytes do not hold its content";
  const char* no_frame = "the chunk's bytes cannot be decompressed";
  expect_refused([&] { unpack({}); }, kChunkHeadBytes, no_content);
  expect_refused([&] { unpack(noise(300)); }, kChunkHeadBytes, no_content);
  expect_refused([&] { unpack(other.stored); }, kChunkHeadBytes, no_content);
  Bytes bytes = sound.stored;
  bytes.insert(bytes.end(), other.stored.begin(), other.stored.end());
  expect_refused([&] { unpack(bytes); }, kChunkHeadBytes, no_frame);
  bytes = sound.stored;
  bytes.push_back(std::byte{1});
  expect_refused([&] { unpack(bytes); }, kChunkHeadBytes, no_frame);
  for (std::size_t length = 0; length < sound.stored.size(); ++length) {
    EXPECT_TRUE(is_refused([&] { unpack(copy_of(std::span(sound.stored).first(length))); })) << length;
  }
  // Changes within the frame: whatever decompresses has the length that the head states.
  int refused = 0, same_length = 0;
  for_each_changed_bit(sound.stored, [&](const Bytes& changed, std::size_t) {
    Bytes content;
    if (is_refused([&] { content = unpack(changed); })) {
      ++refused;
    } else {
      ++same_length;
      EXPECT_EQ(content.size(), 5000u);
    }
  });
  EXPECT_GT(refused, 0);
  EXPECT_GT(same_length, 0);
}

TEST(RecordingChunks, UnknownFlagsAreRefused) {
  const ChunkHead sound{.kind = ChunkKind::calls, .content_bytes = 10, .stored_bytes = 10};
  EXPECT_EQ(read_chunk_head(sealed(sound)).stored_bytes, 10u);
  for (unsigned flag = 8; flag < 256; flag *= 2) {
    ChunkHead head = sound;
    head.flags = static_cast<std::uint8_t>(flag);
    expect_head_refused(sealed(head), kFlagsOffset, "the chunk has unknown flags");
  }
  for (const std::uint16_t not_zero : {std::uint16_t{1}, std::uint16_t{0x8000}}) {
    expect_head_refused(sealed(sound, not_zero), kFlagsOffset, "the chunk has unknown flags");
  }
}

TEST(RecordingChunks, ContentThatIsNotCompressedHasAsManyBytesAsAreStored) {
  for (const std::uint64_t stored : {0u, 99u, 101u}) {
    expect_head_refused(sealed({.kind = ChunkKind::calls, .content_bytes = 100, .stored_bytes = stored}),
                        kStoredBytesOffset, kWrongSize);
  }
}

TEST(RecordingChunks, MayNotExpandToMoreThanTheLimitOfTheirKind) {
  for (const ChunkKind kind : kKinds) {
    const Expansion most = most_expansion(kind);
    const auto head = [&](std::uint64_t content, std::uint64_t stored) {
      return sealed(
          {.kind = kind, .flags = kChunkCompressed, .content_bytes = content, .stored_bytes = stored});
    };
    const std::uint64_t stored = 1000, content = most.times * stored + most.free;
    EXPECT_EQ(read_chunk_head(head(content, stored)).content_bytes, content);
    expect_head_refused(head(content + 1, stored), kStoredBytesOffset, kWrongSize);
    expect_head_refused(head(content, stored - 1), kStoredBytesOffset, kWrongSize);
    EXPECT_EQ(read_chunk_head(head(most.free, 0)).content_bytes, most.free);
    expect_head_refused(head(most.free + 1, 0), kStoredBytesOffset, kWrongSize);
    // Nor may it be longer than its content by more than an empty frame that fills it up.
    EXPECT_EQ(read_chunk_head(head(content, content + 7)).stored_bytes, content + 7);
    expect_head_refused(head(content, content + 8), kStoredBytesOffset, kWrongSize);
    // Numbers near the largest do not wrap around.
    expect_head_refused(head(~std::uint64_t{0}, ~std::uint64_t{0}), kStoredBytesOffset, kWrongSize);
    const std::uint64_t largest = kMostContentBytes;
    EXPECT_EQ(read_chunk_head(head(largest, largest)).content_bytes, largest);
    expect_head_refused(head(largest + 1, largest + 1), kStoredBytesOffset, kWrongSize);
    expect_head_refused(sealed({.kind = kind, .content_bytes = largest + 1, .stored_bytes = largest + 1}),
                        kStoredBytesOffset, kWrongSize);
  }
}

// Zeros compress better than any limit allows: what is stored is filled up.
TEST(RecordingChunks, ArePackedWithinTheLimitOfTheirKind) {
  for (const ChunkKind kind : kKinds) {
    const Expansion most = most_expansion(kind);
    for (const std::size_t size : {4096u, 4097u, 5000u, 10'000u, 1'000'000u}) {
      const Chunk chunk = packed({.kind = kind}, Bytes(size));
      const ChunkHead head = read_chunk_head(chunk.head);
      EXPECT_GE(most.times * head.stored_bytes + most.free, size);
      EXPECT_LT(head.stored_bytes, size / most.times + 100);
      EXPECT_EQ(unpack_chunk(head, chunk.stored), Bytes(size));
    }
  }
}

TEST(RecordingChunks, MoreContentThanTheLimitIsAnError) {
  ChunkPacker packer(1);
  const std::byte byte{};
  // None of them is read.
  const std::span<const std::byte> endless(&byte, static_cast<std::size_t>(kMostContentBytes + 1));
  try {
    packer.pack({.kind = ChunkKind::calls}, endless);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_many);
    EXPECT_NE(std::string(error.what()).find("at most 68719476736"), std::string::npos) << error.what();
  }
}

TEST(RecordingHeads, AreReadAsTheyWereWritten) {
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, kMostWriterBytes, kMostWriterBytes + 1}) {
    const std::string name(length, 'x');
    Bytes bytes = write_recording_head(name);
    EXPECT_LE(bytes.size(), kMostHeadBytes);
    const std::size_t size = bytes.size();
    bytes.resize(size + 500, std::byte{7});  // chunks follow
    const RecordingHead head = read_recording_head(bytes);
    EXPECT_EQ(head.version, kRecordingVersion);
    EXPECT_EQ(head.minor, kRecordingMinor);
    EXPECT_EQ(head.writer, name.substr(0, kMostWriterBytes));
    EXPECT_EQ(head.bytes, size);
  }
}

TEST(RecordingHeads, WithAnyBitChangedAreRefused) {
  Bytes bytes = write_recording_head("the writer");
  const std::size_t size = bytes.size();
  for_each_changed_bit(bytes, [&](const Bytes& changed, std::size_t byte) {
    Bytes longer = changed;
    longer.resize(size + 500);
    for (const Bytes& wrong : {changed, longer}) {
      try {
        read_recording_head(wrong);
        ADD_FAILURE() << "byte " << byte << " may be changed";
      } catch (const RefusedBytes& refused) {
        EXPECT_LE(refused.offset, wrong.size());
        const bool of_the_version = byte >= 8 && byte < 12;
        EXPECT_EQ(refused.code() == ErrorCode::wrong_version, of_the_version) << refused.what();
      }
    }
  });
}

TEST(RecordingHeads, ThatEndTooEarlyAreRefused) {
  const Bytes bytes = write_recording_head("the writer");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    expect_refused([&] { read_recording_head(std::span(bytes).first(length)); }, length,
                   "the recording ends too early");
  }
}

// With right checksums: by another version, or made on purpose.
TEST(RecordingHeads, OfOtherColumnsOrWithTooLongANameAreRefused) {
  constexpr std::size_t kLength = 20, kLayout = 24;
  const auto seal = [](Bytes bytes) {
    ByteWriter hash;
    hash.put(hash_of_bytes(std::span(bytes).first(bytes.size() - 8)));
    std::copy(hash.bytes().begin(), hash.bytes().end(), bytes.end() - 8);
    return bytes;
  };
  Bytes bytes = write_recording_head("the writer");
  EXPECT_EQ(seal(bytes), bytes);
  bytes[kLayout] ^= std::byte{1};
  expect_refused([&] { read_recording_head(seal(bytes)); }, kLayout,
                 "this was recorded by a version with other columns: the writer");
  bytes = write_recording_head(std::string(kMostWriterBytes, 'x'));
  bytes.insert(bytes.end() - 8, std::byte{'x'});
  bytes[kLength] = std::byte{1};  // of 257
  expect_refused([&] { read_recording_head(seal(bytes)); }, kLength, "the writer's name is too long");
}

}  // namespace
}  // namespace scree::test
