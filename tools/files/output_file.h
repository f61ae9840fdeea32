// Output files of programs: named on the command line, checked before the work, put in place after it. Used
// by the command, the soak and the benchmarks.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace scree::files {

/// A file as the command line names it.
struct NamedFile {
  std::string argument;  ///< the argument that named it, for messages: "--json", "SCENE"; may be empty
  std::string path;
};

/// Call first. Replaces standard streams that the caller has closed by an end that refuses all data, so that
/// no file of the program takes their descriptors. Also turns a file that grows beyond its limit into a write
/// error instead of the end of the process.
void prepare_process();

/// Whether output to this path goes to a standard stream of the process: 1 for standard output, 2 for
/// standard error. Not so for a device that discards all output.
bool is_standard_stream(const std::string& path, int stream);

/// Throws Error for an output that cannot be written, that a recorder is writing to, or that is an input or
/// another output under any name. Changes nothing.
void check_outputs(std::span<const NamedFile> inputs, std::span<const NamedFile> outputs);

/// Replaces the content of the file by the text. The old content stays until the text is on the disk, and
/// stays if that fails. Writes directly to devices, pipes and files that the process has open, such as
/// /dev/stdout, and to files in folders that accept no new ones. Throws std::runtime_error.
void write_file(const NamedFile& file, std::string_view text);

/// Writes all of the text, after earlier output to stdout and std::cout. Throws std::runtime_error.
void write_standard_output(std::string_view text);

}  // namespace scree::files
