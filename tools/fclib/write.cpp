// See fclib.h. The library of FCLIB adds to files that exist, so it writes a new one, whose content then goes
// where it is wanted.
extern "C" {
#include <fclib.h>
}
#include <parallel/solvers/whole_system/first_substep.h>
#include <tools/fclib/fclib.h>
#include <tools/files/output_file.h>
#include <tools/scenes/scene.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace scree::fclib {
namespace {

constexpr int kMostIterations = 100;  // of the figure alone
constexpr double kTolerance = 1e-12;  // m/s

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "scree-fclib-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The library's structures hold pointers to what may be changed; it changes nothing when it writes.
class Lent {
 public:
  Lent(const SparseColumns& from, const char* comment)
      : columns_(from), comment_(comment), info_{comment_.data(), 0, 0, 0}, matrix_{} {
    matrix_.nzmax = static_cast<int>(columns_.value.size());
    matrix_.m = columns_.rows;
    matrix_.n = columns_.columns;
    matrix_.p = columns_.start.data();
    matrix_.i = columns_.row.data();
    matrix_.x = columns_.value.data();
    matrix_.nz = -1;  // compressed columns
    matrix_.info = &info_;
  }
  Lent(const Lent&) = delete;
  Lent& operator=(const Lent&) = delete;
  fclib_matrix* matrix() { return &matrix_; }

 private:
  SparseColumns columns_;
  std::string comment_;
  fclib_matrix_info info_;
  fclib_matrix matrix_;
};

void write_new(ContactProblem problem, FclibText text, const std::string& path) {
  Lent response(problem.response, "W = J M^-1 J^T"), coupling(problem.coupling, "V"),
      held(problem.held_response, "R");
  fclib_info info{text.title.data(), text.description.data(), text.math_info.data()};
  fclib_local local{};
  local.W = response.matrix();
  if (problem.held() > 0) {
    local.V = coupling.matrix();
    local.R = held.matrix();
    local.s = problem.held_speed.data();
  }
  local.mu = problem.friction.data();
  local.q = problem.free_speed.data();
  local.spacedim = 3;
  local.info = &info;
  if (fclib_write_local(&local, path.c_str()) != 1) throw std::runtime_error("FCLIB could not write " + path);
}

std::string description_of(const FclibFigures& figures) {
  std::ostringstream text;
  text << figures.points << " contact points and " << figures.held_rows << " held rows after " << figures.at
       << " steps; impulses over a substep of " << figures.substep
       << " s, in N s and m/s; three rows a point, the normal first";
  return text.str();
}

}  // namespace

void check_available() {}

void write(const ContactProblem& problem, const FclibText& text, const std::string& file) {
  if (problem.points() == 0) throw Error("fclib: nothing touches, and a problem needs a contact point");
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "problem.hdf5").string();
  write_new(problem, text, path);
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  if (!stream || bytes.str().empty()) throw std::runtime_error(path + ": cannot be read");
  files::write_file({"FILE", file}, bytes.str());
}

FclibFigures write(const std::vector<scenes::Scene>& worlds, const FclibOptions& options) {
  if (worlds.size() != 1) {
    throw Error("fclib: the scene " + worlds.front().name + " consists of " + std::to_string(worlds.size()) +
                " worlds; say --set worlds=1");
  }
  const scenes::Scene& scene = worlds.front();
  Workers workers(WorkersOptions{.threads = options.threads, .isa = options.isa});
  WorldSettings settings = scene.settings;
  settings.sleeping = false;
  World world(settings);
  std::vector<BodyId> bodies = scenes::populate(world, scene);
  for (int i = 0; i < options.at; ++i) {
    scenes::direct(world, scene, bodies, i, options.dt);
    step(world, options.dt, workers);
  }
  scenes::direct(world, scene, bodies, options.at, options.dt);
  const ContactProblem problem = contact_problem_of(world, options.dt, workers);
  const ContactSolution solution = solve_contact_problem(problem, kMostIterations, kTolerance);
  FclibFigures figures{scene.name,          options.file,      options.at,
                       problem.substep,     problem.points(),  problem.held(),
                       solution.iterations, solution.residual, solution.natural_error};
  write(problem,
        {"Scree: " + scene.name, description_of(figures),
         "W is symmetric and positive semi-definite; more rows than degrees of freedom make it singular"},
        options.file);
  return figures;
}

}  // namespace scree::fclib
