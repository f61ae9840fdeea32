// The files that programs write: named on the command line, checked before the work, put in place after it.
// Used by the command, the soak and the benchmarks.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace scree::files {

/// A file as a command line names it.
struct NamedFile {
  std::string argument;  ///< what named it, for messages: "--json", "SCENE"; may be empty
  std::string path;
};

/// To be called first: gives standard streams that the caller has closed an end that refuses all data, so
/// that no file of the program's takes their place, and makes a file that grows beyond its limit an error of
/// writing instead of the end of the process.
void prepare_process();

/// Whether what is written to this path comes out where a standard stream of the process does: 1 for standard
/// output, 2 for standard error. A device that swallows everything is neither.
bool is_standard_stream(const std::string& path, int stream);

/// Throws Error for an output that cannot be written, that a recorder is writing to, and that is an input or
/// another output under whatever name. Changes nothing.
void check_outputs(std::span<const NamedFile> inputs, std::span<const NamedFile> outputs);

/// Makes the text the content of the file. What was there stays until the text is on the disk, and stays if
/// it does not get there. Devices, pipes and what the process has open, such as /dev/stdout, are written to
/// as they are, and so are files in folders that take no new ones. Throws std::runtime_error.
void write_file(const NamedFile& file, std::string_view text);

/// Writes all of the text, after what was printed to stdout and std::cout. Throws std::runtime_error.
void write_standard_output(std::string_view text);

}  // namespace scree::files
