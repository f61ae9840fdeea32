// Recordings as programs read them: messages name the file, and a replay that differs is no result.
#pragma once

#include <scree/error.h>
#include <scree/recording.h>

#include <stdexcept>
#include <string>

namespace scree::files {

/// Calls work(). The library's messages describe bytes and values; with several files the user must know
/// which one is meant. Files are checked only as far as they are played.
template <class Work>
auto naming(const std::string& file, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    const std::string reason = error.what();
    throw Error(reason.find(file) != std::string::npos ? reason : file + ": " + reason);
  }
}

inline Player open_recording(const std::string& file) {
  return naming(file, [&] { return Player(file); });
}

/// Throws std::runtime_error where the last step played has another hash than the recorded one.
inline void check_repeats(const Player& player, const std::string& file) {
  const std::optional<std::uint64_t> hash = player.recorded_hash();
  if (!hash || *hash == player.world().hash()) return;
  throw std::runtime_error(file + ": at step " + std::to_string(player.position()) +
                           " the replay differs from the recording; `scree replay --verify` says where");
}

}  // namespace scree::files
