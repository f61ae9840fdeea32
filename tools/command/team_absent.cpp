// A build without MPI; see team.h.
#include <tools/command/team.h>

namespace scree::command {

std::unique_ptr<Team> make_team() {
  throw Error("--distributed: this build has no MPI; configure it with -DSCREE_MPI=ON");
}

}  // namespace scree::command
