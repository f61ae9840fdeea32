// See fclib.h: of a build without FCLIB.
#include <tools/fclib/fclib.h>

namespace scree::fclib {

void check_available() {
  throw Error(
      "fclib: this build cannot write the FCLIB format; install libfclib-dev and build again, "
      "with a static library (see SCREE_FCLIB)");
}

void write(const ContactProblem&, const FclibText&, const std::string&) { check_available(); }

FclibFigures write(const std::vector<scenes::Scene>&, const FclibOptions&) {
  check_available();
  return {};
}

}  // namespace scree::fclib
