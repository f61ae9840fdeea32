// See team_watch.h. A signal's handler may do little: all that it writes is prepared before.
#include <tools/command/team_watch.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

namespace scree::command {

namespace {

constexpr std::size_t kMostNote = 1024;
constexpr useconds_t kAwait = 300'000;  // so that ranks which end with this one are not taken for dead

struct Watched {
  RankProcess rank;
  char note[96];  // "scree: rank 3 (process 1234) has died\n"
};

// Written by the thread that steps, read by the handler: two notes, of which one is complete.
struct Notes {
  char text[2][kMostNote] = {};
  std::atomic<int> current = 0;
};

std::vector<Watched>* watched = nullptr;  // for the rest of the process
int watching_rank = 0;
Notes checkpoint_note;
std::atomic<bool> has_told = false;  // notes stay as they are

bool is_dead(pid_t process) { return kill(process, 0) != 0 && errno == ESRCH; }

void write_text(const char* text) {
  const char* rest = text;
  std::size_t left = std::strlen(text);
  while (left > 0) {
    const ssize_t written = write(STDERR_FILENO, rest, left);
    if (written <= 0) return;
    rest += written;
    left -= static_cast<std::size_t>(written);
  }
}

// Writes what is lost; nothing but the checkpoint where no rank of this machine has died.
void on_termination(int) {
  if (has_told.exchange(true)) {
    usleep(kAwait);
    _exit(128 + SIGTERM);
  }
  int first_living = watching_rank;
  for (const Watched& one : *watched) {
    if (!is_dead(one.rank.process)) first_living = std::min(first_living, one.rank.rank);
  }
  if (first_living == watching_rank) {
    for (const Watched& one : *watched) {
      if (is_dead(one.rank.process)) write_text(one.note);
    }
    write_text(checkpoint_note.text[checkpoint_note.current]);
  }
  usleep(kAwait);
  _exit(128 + SIGTERM);
}

}  // namespace

void watch_ranks(const std::vector<RankProcess>& ranks, int own_rank) {
  watched = new std::vector<Watched>;
  for (const RankProcess& rank : ranks) {
    Watched& one = watched->emplace_back(Watched{rank, {}});
    const std::string note = "scree: rank " + std::to_string(rank.rank) + " (process " +
                             std::to_string(rank.process) + ") has died\n";
    std::strncpy(one.note, note.c_str(), sizeof one.note - 1);
  }
  watching_rank = own_rank;
  struct sigaction action {};
  action.sa_handler = on_termination;
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, nullptr);
}

void note_checkpoint(const std::string& file, std::uint64_t step) {
  if (has_told) return;
  const int next = 1 - checkpoint_note.current;
  std::string note = "scree: the last checkpoint is " + file + ", after step " + std::to_string(step) +
                     "; go on with --resume " + file + "\n";
  if (note.size() >= kMostNote) note = note.substr(0, kMostNote - 2) + "\n";
  std::strncpy(checkpoint_note.text[next], note.c_str(), kMostNote - 1);
  checkpoint_note.current = next;
}

void stop_watching() { has_told = true; }

std::string describe_losses() {
  std::string all;
  if (watched != nullptr) {
    for (const Watched& one : *watched) {
      if (is_dead(one.rank.process)) all += one.note;
    }
  }
  return all + checkpoint_note.text[checkpoint_note.current];
}

}  // namespace scree::command
