// See film.h. ffmpeg reads PNG files one behind the other from its standard input, so that its list of
// pictures is that of this run, whatever lies in the folder. It runs in a process of its own without a shell.
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <tools/render/film.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

extern char** environ;

namespace scree::render {

bool is_installed(const std::string& program) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = (std::filesystem::path(folder) / program).string();
    std::error_code problem;
    if (std::filesystem::is_regular_file(file, problem) && access(file.c_str(), X_OK) == 0) return true;
  }
  return false;
}

Film::Film(const std::string& file, int pictures_per_second) : file_(file) {
  int ends[2];  // a socket, because writing to one whose reader has died need not raise a signal
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail(std::strerror(errno));
  std::vector<std::string> words = {"ffmpeg", "-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png",
                                    "-framerate", std::to_string(pictures_per_second), "-i", "-",
                                    // the color format that all players know takes even sides
                                    "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
                                    "file:" + file};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  const int problem = posix_spawnp(&process_, "ffmpeg", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  to_ffmpeg_ = ends[0];
  if (problem == 0) return;
  process_ = -1;
  close_and_wait();
  fail(std::strerror(problem));
}

Film::~Film() { close_and_wait(); }

void Film::add(std::string_view png) {
  while (!png.empty()) {
    const ssize_t sent = send(to_ffmpeg_, png.data(), png.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      const int problem = errno;
      close_and_wait();
      fail(std::strerror(problem));
    }
    png.remove_prefix(static_cast<std::size_t>(sent));
  }
}

void Film::finish() {
  const int status = close_and_wait();
  if (status != 0)
    fail("it ended with status " + std::to_string(WIFEXITED(status) ? WEXITSTATUS(status) : status));
}

int Film::close_and_wait() {
  if (const int socket = std::exchange(to_ffmpeg_, -1); socket >= 0) ::close(socket);
  int status = 0;
  if (const pid_t process = std::exchange(process_, -1); process > 0) {
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
  }
  return status;
}

void Film::fail(const std::string& reason) { throw std::runtime_error(file_ + ": ffmpeg: " + reason); }

}  // namespace scree::render
