#include "io/open_volume.h"

#include <filesystem>
#include <utility>

#include "io/files/file_list.h"
#include "io/formats.h"
#include "io/relabelled.h"
#include "io/sequence.h"
#include "io/synth/synth_source.h"
#include "io/web/address.h"
#include "src/base/error.h"

namespace sluice {
namespace {

std::unique_ptr<VolumeSource> openOne(const std::string& name, const OpenOptions& options) {
  const NamedInput input = lookAt(name, options);
  const Format& format = formatOf(input, options);
  requireTaken(input.store ? input.store->name() : name, format, options);
  return respaced(format.open(input, options), options.spacing);
}

std::unique_ptr<VolumeSource> openSeveral(const std::vector<std::string>& files,
                                          const OpenOptions& options) {
  for (const Format& format : formats()) {
    if (format.join == nullptr) continue;
    std::unique_ptr<VolumeSource> joined = format.join(files, options);
    if (!joined) continue;
    requireTaken(files[0], format, options);
    return joined;
  }
  return std::make_unique<SequenceSource>(
      files, [options](const std::string& file, const std::optional<ChannelWish>& channel) {
        OpenOptions of_step = options;
        if (channel) of_step.channel = *channel;
        return openOne(file, of_step);
      });
}

// The names that a pattern stands for, such as "step_###.h5:/set"; another name is itself.
std::vector<std::string> namesOf(const std::string& input) {
  if (isSynthSpec(input) || isAddress(input)) return {input};
  InputPath pattern = splitInputPath(input);
  if (!isPattern(pattern.file)) pattern = {input, ""};
  if (!isPattern(pattern.file)) return {input};
  const auto matches = expandPattern(pattern.file);
  requireOneSeries(pattern.file, matches);
  const std::string inside = pattern.inside.empty() ? "" : ":" + pattern.inside;
  std::vector<std::string> names;
  names.reserve(matches.size());
  for (const std::filesystem::path& file : matches) names.push_back(file.string() + inside);
  return names;
}

// Sparse files may describe a volume of any size. Its voxels are counted in many places.
std::unique_ptr<VolumeSource> countable(std::unique_ptr<VolumeSource> source,
                                        const std::string& file) {
  const Vec3i dims = source->layout().dims;
  if (!isCountable(dims))
    fail("{}: expected at most 2^59 voxels together, found {} x {} x {}", file, dims.x, dims.y,
         dims.z);
  return source;
}

}  // namespace

std::unique_ptr<VolumeSource> openVolume(const std::string& input, const OpenOptions& options) {
  return openVolume(std::vector<std::string>{input}, options);
}

std::unique_ptr<VolumeSource> openVolume(const std::vector<std::string>& inputs,
                                         const OpenOptions& options) {
  SLUICE_CHECK(!inputs.empty());
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    for (std::string& name : namesOf(input)) files.push_back(std::move(name));
  }
  if (files.size() == 1) return countable(openOne(files[0], options), files[0]);
  const std::optional<std::string> note = orderByNumbers(files);
  return withNote(countable(openSeveral(files, options), files[0]), note);
}

namespace {

// The files of a series with one file for each time step; empty for other volumes.
std::vector<std::filesystem::path> filesOfSteps(VolumeSource& source) {
  const int64_t steps = source.layout().time_steps;
  if (steps < 2) return {};
  const std::vector<std::string> files = source.files();
  if (static_cast<int64_t>(files.size()) != steps) return {};
  return {files.begin(), files.end()};
}

}  // namespace

std::optional<std::string> missingStep(VolumeSource& source, int64_t time) {
  const int64_t steps = source.layout().time_steps;
  const auto file = missingFile(filesOfSteps(source), time < steps ? 0 : time - steps + 1);
  return file ? std::optional(file->string()) : std::nullopt;
}

std::vector<int64_t> numbersOfSteps(VolumeSource& source) {
  return numbersOf(filesOfSteps(source));
}

}  // namespace sluice
