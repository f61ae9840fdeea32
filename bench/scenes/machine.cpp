// The machine and the build: read from Linux's own files.
#include "bench/scenes/machine.h"

#include <scree/scree.h>

#include <sched.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sstream>

namespace scree::bench {
namespace {

// The value of the first line of `file` that begins with `key`, without separators and quotes around it.
std::string value_in(const char* file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t begin = line.find_first_not_of(" \t:=\"", key.size());
    const std::size_t end = line.find_last_not_of(" \t\"");
    return begin == std::string::npos ? std::string{} : line.substr(begin, end - begin + 1);
  }
  return "unknown";
}

std::string processor() {
  const char* file = "/proc/cpuinfo";
  return value_in(file, "model name") + " (" + value_in(file, "vendor_id") + " family " +
         value_in(file, "cpu family") + " model " + value_in(file, "model\t") + "), cache " +
         value_in(file, "cache size") + ", widest instruction set " + isa_name(Workers(1).isa());
}

std::string cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? std::to_string(CPU_COUNT(&set)) : "unknown";
}

std::string memory() {
  const double kibibytes = std::strtod(value_in("/proc/meminfo", "MemTotal").c_str(), nullptr);
  std::ostringstream text;
  text.precision(3);
  text << kibibytes / (1024.0 * 1024.0) << " GiB";
  return text.str();
}

std::string system_name() {
  utsname name{};
  uname(&name);
  return value_in("/etc/os-release", "PRETTY_NAME") + ", " + name.sysname + " " + name.release;
}

std::string compiler() {
#if defined(__clang__)
  const std::string name = "clang ";
#else
  const std::string name = "g++ ";
#endif
#ifdef NDEBUG
  const std::string build = ", release";
#else
  const std::string build = ", with assertions: not for comparison";
#endif
  return name + __VERSION__ + build;
}

std::string load() {
  double average = 0.0;
  std::ostringstream text;
  if (getloadavg(&average, 1) == 1) text << average << " at the start";
  return text.str();
}

std::string date() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> describe_machine() {
  return {{"processor", processor()}, {"cores", cores()}, {"memory", memory()}, {"system", system_name()},
          {"compiler", compiler()},   {"load", load()},   {"date", date()}};
}

}  // namespace scree::bench
