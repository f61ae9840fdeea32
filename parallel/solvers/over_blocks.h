// Work over all blocks of constraints at once, where their order does not matter: before the first substep
// and after the last one.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

namespace scree {

// Calls the works for all chunks, which do not touch what others do.
template <class ContactWork, class JointWork>
void over_blocks(const Constraints& constraints, Crew& crew, ContactWork&& contact_work,
                 JointWork&& joint_work, const char* name = __builtin_FUNCTION()) {
  const int joints = static_cast<int>(constraints.joint_chunks.size());
  crew.run(
      joints + static_cast<int>(constraints.contact_chunks.size()),
      [&](int place, int) {
        const int chunk = constraints.share_order[place];
        if (chunk < joints) {
          joint_work(constraints.joint_chunks[chunk]);
        } else {
          contact_work(constraints.contact_chunks[chunk - joints]);
        }
      },
      name);
}

}  // namespace scree
