// Outputs: every file that a command is going to write, checked against its inputs and against one
// another before anything is read in full or written. Every command has one and names its files
// there; nothing is written under a name that is not.
//
// Two names are the same file when they lead to the same inode, through symbolic and hard links, or
// to the same name in the same folder if there is no file yet.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/file_kind.h"

namespace sluice {

class Outputs {
 public:
  // For a command without --force: an existing file is replaced only by a file of its own kind
  // (mayReplace).
  Outputs() = default;
  // `force`: existing files may be replaced whatever they hold. Files that are read never are.
  explicit Outputs(bool force) : force_(force) {}

  // A file or folder that the command reads. Names that do not exist are no concern of this class.
  void reads(const std::filesystem::path& path);
  void reads(const std::vector<std::string>& paths);
  // A file that it is going to write, named by `option` ("--report").
  void writes(const std::string& option, const std::filesystem::path& path, FileKind kind);
  // A trace, with every file that its format takes.
  void writesTrace(const std::string& option, const std::filesystem::path& path);
  // A folder that it is going to write, whose old contents the writer checks itself.
  void writesFolder(const std::string& option, const std::filesystem::path& path);

  // Throws Error, in one line, for the first output that is an input or another output, or whose
  // name is too long or in a folder that is missing or closed; does not check existing files. The
  // same while not all inputs are known yet.
  void checkNames() const { checkNames({}); }
  // The same, and for the first that would replace a file of another kind. `more_read`: files that
  // are known to be read only now, such as those that a volume's header names.
  void check(const std::vector<std::string>& more_read = {}) const;

 private:
  struct Output {
    std::string option;
    std::filesystem::path path;
    FileKind kind;
    bool is_folder = false;
  };
  void checkNames(const std::vector<std::string>& more_read) const;
  void checkExisting(const Output& output) const;

  const std::optional<bool> force_;  // unset: there is no --force
  std::vector<std::filesystem::path> inputs_;
  std::vector<Output> outputs_;
};

}  // namespace sluice
