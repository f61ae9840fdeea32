// A team of MPI's processes; see team.h.
#include <sched.h>
#include <scree/mpi.h>
#include <tools/command/delayed_transport.h>
#include <tools/command/team.h>
#include <tools/command/team_watch.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree::command {

namespace {

constexpr std::chrono::milliseconds kTimeToTell{500};

class MpiTeam final : public Team {
 public:
  MpiTeam() {
    int provided = 0;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_FUNNELED)
      throw Error("--distributed: MPI cannot be initialized for programs of many threads");
    transport_.emplace(MPI_COMM_WORLD);
    MPI_Comm neighbors = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &neighbors);
    MPI_Comm_size(neighbors, &here_);
    std::vector<RankProcess> processes(static_cast<std::size_t>(here_));
    const RankProcess own{transport_->rank(), getpid()};
    MPI_Allgather(&own, sizeof own, MPI_BYTE, processes.data(), sizeof own, MPI_BYTE, neighbors);
    watch_ranks(processes, own.rank);
    MPI_Comm_free(&neighbors);
  }
  ~MpiTeam() override {
    world_.reset();
    delayed_.reset();
    transport_.reset();
    MPI_Finalize();
  }
  MpiTeam(const MpiTeam&) = delete;
  MpiTeam& operator=(const MpiTeam&) = delete;

  bool leads() const override { return transport_->rank() == 0; }
  int threads_each(int asked) const override {
    if (asked != 0) return asked;
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / here_);
    cpu_set_t bound;  // mpirun may have bound this process to some of them
    const bool is_known = sched_getaffinity(0, sizeof bound, &bound) == 0;
    return is_known ? std::min(cores, std::max(1, CPU_COUNT(&bound))) : cores;
  }
  int processes() const override { return transport_->ranks(); }
  int processes_here() const override { return here_; }
  void take(World world, double latency) override {
    meet();
    has_begun_ = true;
    world_.emplace(std::move(world), delayed_by(latency));
  }
  DistributedWorld& world() override { return *world_; }
  DistributedWorld read(const std::string& checkpoint, double latency, Workers& workers) override {
    checkpoint_ranks(checkpoint);  // what is no checkpoint is told by one
    meet();
    has_begun_ = true;
    return read_checkpoint(checkpoint, delayed_by(latency), workers);
  }
  void replace(DistributedWorld world) override { world_ = std::move(world); }
  DistributedPlayer play(const std::string& recording, std::optional<std::uint64_t> from,
                         Workers& workers) override {
    meet();
    has_begun_ = true;
    return DistributedPlayer(recording, from, *transport_, workers);
  }
  std::int64_t add_up(std::int64_t own) override {
    transport_->add_up({&own, 1});
    return own;
  }
  void meet() override {
    if (add_up(0) == 0) return;
    add_up(0);  // until that one has told why
    has_begun_ = true;
    throw Error("--distributed: another rank has failed");
  }
  void note_checkpoint(const std::string& file, std::uint64_t step) override {
    command::note_checkpoint(file, step);
  }
  [[noreturn]] void fail(const std::exception& error, int exit_code) override {
    stop_watching();
    if (has_begun_) {
      // Where all fail alike, the first one ends the others before they tell the same. What one rank fails by
      // alone goes untold if rank 0 fails meanwhile, too.
      if (!leads()) std::this_thread::sleep_for(kTimeToTell);
      tell(error, describe_losses());
      MPI_Abort(MPI_COMM_WORLD, exit_code);
    }
    // Others wait in meet(), or fail alike: then one of them tells.
    const std::int64_t failed = add_up(1);
    if (leads() || failed < transport_->ranks()) tell(error, "");
    add_up(1);
    transport_.reset();
    MPI_Finalize();
    std::_Exit(exit_code);
  }

 private:
  // All at once: the lines of processes mix.
  void tell(const std::exception& error, const std::string& more) const {
    const std::string line =
        "scree: rank " + std::to_string(transport_->rank()) + ": " + error.what() + "\n" + more;
    std::cerr << line << std::flush;
  }

  // us; the same in each call.
  Transport& delayed_by(double latency) {
    if (latency == 0.0) return *transport_;
    if (!delayed_)
      delayed_.emplace(*transport_, std::chrono::nanoseconds(static_cast<std::int64_t>(1e3 * latency)));
    return *delayed_;
  }

  std::optional<MpiTransport> transport_;
  std::optional<DelayedTransport> delayed_;
  std::optional<DistributedWorld> world_;
  int here_ = 1;  // processes on this machine
  bool has_begun_ = false;
};

}  // namespace

std::unique_ptr<Team> make_team() { return std::make_unique<MpiTeam>(); }

}  // namespace scree::command
