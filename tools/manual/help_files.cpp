#include "tools/manual/help_files.h"

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "tools/manual/completions.h"
#include "tools/manual/manual_page.h"

namespace sluice {
namespace {

void writeHelpFile(const std::filesystem::path& path, const std::string& text) {
  std::error_code failed;
  std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) fail("{}: {}", path.parent_path().string(), failed.message());
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

void writeHelpFiles(CLI::App& program, const std::filesystem::path& folder) {
  const CommandText text = commandText(program);
  for (const CommandText* command : withCommandsBelow(text))
    writeHelpFile(folder / "man" / "man1" / manualPageName(*command), manualPage(*command, text));
  writeHelpFile(folder / "bash-completion" / "completions" / "sluice", bashCompletion(text));
  writeHelpFile(folder / "zsh" / "vendor-completions" / "_sluice", zshCompletion(text));
  writeHelpFile(folder / "fish" / "vendor_completions.d" / "sluice.fish", fishCompletion(text));
}

}  // namespace sluice
