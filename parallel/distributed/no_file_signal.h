// Keeps signals of failed writes from ending the process: errors tell of them.
#pragma once

#include <cerrno>
#include <csignal>
#include <ctime>

namespace scree {

// Of the calling thread, while this is there. A limit of the file's size is SIGXFSZ, a pipe without a reader
// SIGPIPE; what was pending before stays so, what others send to the process meanwhile may be lost.
class NoFileSignal {
 public:
  NoFileSignal() {
    sigemptyset(&blocked_);
    sigset_t pending;
    sigpending(&pending);
    for (const int signal : {SIGXFSZ, SIGPIPE}) {
      if (sigismember(&pending, signal) == 0) sigaddset(&blocked_, signal);
    }
    pthread_sigmask(SIG_BLOCK, &blocked_, &before_);
  }
  ~NoFileSignal() {
    const std::timespec at_once{};
    while (sigtimedwait(&blocked_, nullptr, &at_once) > 0 || errno == EINTR) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoFileSignal(const NoFileSignal&) = delete;
  NoFileSignal& operator=(const NoFileSignal&) = delete;

 private:
  sigset_t blocked_, before_;
};

}  // namespace scree
