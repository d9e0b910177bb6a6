#include "src/parallel/agreement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/error.h"
#include "src/base/files/byte_stream.h"
#include "src/base/values/digest.h"

namespace sluice {
namespace {

constexpr size_t kMostNamed = 4;  // differences in one line

// The statement of a rank, facts in the order in which it makes them.
struct Statement {
  std::vector<Fact> facts;
  std::string advice;

  const Fact* find(const std::string& name) const {
    const auto found = std::find_if(facts.begin(), facts.end(),
                                    [&](const Fact& fact) { return fact.name == name; });
    return found != facts.end() ? &*found : nullptr;
  }
};

void put(ByteWriter& to, const std::string& text) {
  to.list(std::vector<char>(text.begin(), text.end()));
}

std::string textFrom(ByteReader& from) {
  std::vector<char> text;
  if (!from.list(text)) failSystem("a rank's statement of what it draws is cut off");
  return {text.begin(), text.end()};
}

Statement statementIn(const Message& message) {
  ByteReader from(message);
  Statement statement{{}, textFrom(from)};
  while (!from.left().empty()) {
    // Braces evaluate their elements from left to right: the name comes first, then the value.
    Fact fact{textFrom(from), textFrom(from)};
    if (!from.value(fact.digest)) failSystem("a rank's statement of what it draws is cut off");
    statement.facts.push_back(std::move(fact));
  }
  return statement;
}

// "--block is 32, on rank 0 16", "voxels differ". Either may be null, not both.
std::string difference(const Fact* here, const Fact* first) {
  if (here == nullptr)
    return fmt::format("{} is not given, on rank 0 {}", first->name, first->value);
  if (first == nullptr)
    return fmt::format("{} is {}, on rank 0 not given", here->name, here->value);
  if (here->value == first->value) return fmt::format("{} differ", here->name);
  return fmt::format("{} is {}, on rank 0 {}", here->name, here->value, first->value);
}

std::vector<std::string> differences(const Statement& here, const Statement& first) {
  std::vector<std::string> all;
  for (const Fact& fact : here.facts) {
    // Values that would fill lines, such as voxels, are compared by their digests alone.
    const Fact* other = first.find(fact.name);
    if (other == nullptr || other->value != fact.value || other->digest != fact.digest)
      all.push_back(difference(&fact, other));
  }
  for (const Fact& fact : first.facts)
    if (here.find(fact.name) == nullptr) all.push_back(difference(nullptr, &fact));
  return all;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string line;
  for (size_t i = 0; i < std::min(parts.size(), kMostNamed); ++i)
    line += (i == 0 ? "" : "; ") + parts[i];
  if (parts.size() > kMostNamed) line += fmt::format("; and {} more", parts.size() - kMostNamed);
  return line;
}

// The i-th of many positions that cover the volume evenly (multiples of the golden section and its
// kin in three dimensions).
Vec3i samplePosition(int i, Vec3i dims) {
  constexpr Vec3d kSteps{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  Vec3i position;
  for (int a = 0; a < 3; ++a) {
    const double share = std::fmod(kSteps[a] * (i + 1), 1.0);
    position[a] = std::min(static_cast<int64_t>(share * static_cast<double>(dims[a])), dims[a] - 1);
  }
  return position;
}

uint64_t sampleDigest(VolumeSource& source, int64_t time, int samples) {
  constexpr int64_t kRowVoxels = 64;
  const VolumeLayout& layout = source.layout();
  Digest digest;
  std::vector<std::byte> row;
  for (int i = 0; i < samples; ++i) {
    const Vec3i lo = samplePosition(i, layout.dims);
    const Box3 box{lo, {std::min(lo.x + kRowVoxels, layout.dims.x), lo.y + 1, lo.z + 1}};
    row.resize(static_cast<size_t>(box.count()) * bytesPerVoxel(layout.type));
    source.readRegion(time, box, row);
    digest.add(row);
  }
  return digest.value();
}

uint64_t rangesDigest(const SliceRanges& ranges) {
  Digest digest;
  digest.add(std::as_bytes(std::span(ranges.blocks)));
  digest.add(ranges.totals);
  digest.add(ranges.planes);
  digest.add(ranges.background);
  return digest.value();
}

uint64_t placeDigest(const VolumeLayout& layout) {
  Digest digest;
  for (int a = 0; a < 3; ++a) {
    digest.add(layout.spacing[a]);
    digest.add(layout.origin[a]);
    for (int b = 0; b < 3; ++b) digest.add(layout.axes[static_cast<size_t>(a)][b]);
  }
  digest.add(layout.value_scale);
  digest.add(layout.value_offset);
  return digest.value();
}

std::string printSize(Vec3i size) {
  return fmt::format("{} x {} x {}", size.x, size.y, size.z);
}

}  // namespace

void expectAgreement(Team& team, const std::vector<Fact>& facts, std::string_view advice) {
  ByteWriter mine;
  put(mine, std::string(advice));
  for (const Fact& fact : facts) {
    put(mine, fact.name);
    put(mine, fact.value);
    mine.value(fact.digest);
  }
  // Every rank compares all statements, so that all fail with the same line and none waits for
  // others.
  const std::vector<Message> all = team.gatherAll(mine.bytes);
  const Statement first = statementIn(all.front());
  for (size_t rank = 1; rank < all.size(); ++rank) {
    const Statement here = statementIn(all[rank]);
    const std::vector<std::string> found = differences(here, first);
    if (found.empty()) continue;
    const auto others = std::count_if(
        all.begin() + static_cast<int64_t>(rank) + 1, all.end(),
        [&](const Message& other) { return !differences(statementIn(other), first).empty(); });
    failRequest("rank {} of {} would draw something else than rank 0{}: {}; {}", rank, all.size(),
                others > 0 ? fmt::format(" (and {} more ranks)", others) : "", joined(found),
                here.advice);
  }
}

std::vector<Fact> factsOf(VolumeSource& source, int64_t time, const SliceRanges& ranges,
                          int samples) {
  const VolumeLayout& layout = source.layout();
  return {{"the volume's size", printSize(layout.dims)},
          {"the voxel type", std::string(name(layout.type))},
          {"the number of time steps", fmt::format("{}", layout.time_steps)},
          {"the volume's spacing, place and scale of values", "", placeDigest(layout)},
          {"the size of a block", fmt::format("{}", ranges.layout.size)},
          {"least and greatest voxels of blocks", "", rangesDigest(ranges)},
          {"voxels", "", sampleDigest(source, time, samples)}};
}

}  // namespace sluice
