// A team of MPI's processes; see team.h.
#include <sched.h>
#include <scree/mpi.h>
#include <tools/command/team.h>

#include <algorithm>
#include <iostream>
#include <optional>
#include <thread>
#include <utility>

namespace scree::command {

namespace {

class MpiTeam final : public Team {
 public:
  MpiTeam() {
    int provided = 0;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_FUNNELED)
      throw Error("--distributed: MPI cannot be initialized for programs of many threads");
    transport_.emplace(MPI_COMM_WORLD);
  }
  ~MpiTeam() override {
    world_.reset();
    transport_.reset();
    MPI_Finalize();
  }
  MpiTeam(const MpiTeam&) = delete;
  MpiTeam& operator=(const MpiTeam&) = delete;

  bool leads() const override { return transport_->rank() == 0; }
  int threads_each(int asked) const override {
    if (asked != 0) return asked;
    MPI_Comm neighbors = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &neighbors);
    int here = 1;
    MPI_Comm_size(neighbors, &here);
    MPI_Comm_free(&neighbors);
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / here);
    cpu_set_t bound;  // mpirun may have bound this process to some of them
    const bool is_known = sched_getaffinity(0, sizeof bound, &bound) == 0;
    return is_known ? std::min(cores, std::max(1, CPU_COUNT(&bound))) : cores;
  }
  void take(World world) override {
    std::int64_t failed = 0;
    transport_->add_up({&failed, 1});
    has_begun_ = true;
    if (failed > 0) throw Error("--distributed: another rank has failed");
    world_.emplace(std::move(world), *transport_);
  }
  DistributedWorld& world() override { return *world_; }
  [[noreturn]] void fail(const std::exception& error, int exit_code) override {
    if (has_begun_) {
      std::cerr << "scree: rank " << transport_->rank() << ": " << error.what() << std::endl;
      MPI_Abort(MPI_COMM_WORLD, exit_code);
    }
    // Others wait as they take the world, or fail alike: then one of them tells.
    std::int64_t failed = 1;
    transport_->add_up({&failed, 1});
    if (leads() || failed < transport_->ranks())
      std::cerr << "scree: rank " << transport_->rank() << ": " << error.what() << std::endl;
    transport_.reset();
    MPI_Finalize();
    std::_Exit(exit_code);
  }

 private:
  std::optional<MpiTransport> transport_;
  std::optional<DistributedWorld> world_;
  bool has_begun_ = false;
};

}  // namespace

std::unique_ptr<Team> make_team() { return std::make_unique<MpiTeam>(); }

}  // namespace scree::command
