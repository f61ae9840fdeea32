// A film of pictures, made by ffmpeg where it is installed.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>

namespace scree::render {

// Whether the system finds a program of this name.
bool is_installed(const std::string& program);

// Runs ffmpeg beside the caller and hands it pictures. Throws std::runtime_error where ffmpeg fails.
class Film {
 public:
  // Creates or replaces the file, H.264 in MP4.
  Film(const std::string& file, int pictures_per_second);
  ~Film();  // ends the film as it is
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  void add(std::string_view png);
  void finish();

 private:
  [[noreturn]] void fail(const std::string& reason);
  int close_and_wait();  // exit status of ffmpeg

  std::string file_;
  int to_ffmpeg_ = -1;
  pid_t process_ = -1;
};

}  // namespace scree::render
