// How an entry of the table of options is bound to the member that holds its value. Used by the
// table's parts (camera_entries.cpp, look_entries.cpp, picture_entries.cpp and volume_entries.cpp)
// and by the rules of option_rules.cpp alone.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "src/options/option_members.h"
#include "src/options/option_table.h"

namespace sluice {

// The parts of the table, in its order.
std::vector<OptionEntry> cameraEntries();
std::vector<OptionEntry> lookEntries();
std::vector<OptionEntry> pictureEntries();
std::vector<VolumeEntry> volumeEntries();

inline constexpr NumberRange<double> kWorldRange{-1e15, 1e15}, kShareRange{0, 1};

inline OptionKind wordOf(OptionWords words) {
  return {.form = OptionForm::kWord, .words = std::move(words)};
}

// `held`: the member of a subject, constant or not.
template <class Subject, class Held>
EntryOf<Subject> holding(EntryOf<Subject> entry, Held held) {
  entry.get = [words = entry.kind.words, held](const Subject& state) {
    return readMember(words, held(state));
  };
  entry.set = [words = entry.kind.words, held](Subject& state, const OptionValue& value) {
    writeMember(words, value, held(state));
  };
  return entry;
}

// The entry with the name of its field: the one that it gives, or else its key.
template <class Subject>
EntryOf<Subject> inPart(OptionPart part, const std::string& of_field, EntryOf<Subject> entry) {
  entry.part = part;
  entry.field = of_field + (entry.field.empty() ? entry.key : entry.field);
  return entry;
}

// Members of a ViewState that no struct of the library has.
template <class T>
OptionEntry in(T ViewState::*member, OptionEntry entry) {
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.*member; });
}
template <class T>
OptionEntry in(T PictureOptions::*member, OptionEntry entry) {
  const OptionPart part = entry.part;
  return holding(
      inPart(part, "", std::move(entry)), [=](auto& state) -> auto& { return state.*member; });
}
template <class T>
OptionEntry in(T PictureOptions::Lighting::*member, OptionEntry entry) {
  return holding(
      inPart(OptionPart::kTop, "lighting.", std::move(entry)), [=](auto& state) -> auto& {
        return state.lighting.*member;
      });
}
template <class T>
OptionEntry in(T ViewOptions::*member, OptionEntry entry) {
  return holding(
      inPart(OptionPart::kCamera, "view.", std::move(entry)), [=](auto& state) -> auto& {
        return state.view.*member;
      });
}
template <class T>
OptionEntry in(T LookOptions::*member, OptionEntry entry) {
  return holding(
      inPart(OptionPart::kLook, "", std::move(entry)), [=](auto& state) -> auto& {
        return state.look.*member;
      });
}
template <class T>
VolumeEntry in(T VolumeOptions::*member, VolumeEntry entry) {
  return holding(
      inPart(OptionPart::kVolume, "", std::move(entry)), [=](auto& options) -> auto& {
        return options.*member;
      });
}
// One end of the line of sight.
inline OptionEntry in(std::array<double, 3> ViewOptions::LookAt::*member, OptionEntry entry) {
  entry = inPart(OptionPart::kCamera, "view.look_at.", std::move(entry));
  entry.get = [=](const ViewState& state) -> std::optional<OptionValue> {
    if (!state.view.look_at) return std::nullopt;
    return readMember({}, *state.view.look_at.*member);
  };
  entry.set = [=](ViewState& state, const OptionValue& value) {
    if (!state.view.look_at) state.view.look_at.emplace();
    writeMember({}, value, *state.view.look_at.*member);
  };
  return entry;
}

// Conditions that several parts have.
inline bool hasColors(const ViewState& state) {
  return state.look.mode == LookOptions::Mode::kComposite;
}
inline bool hasLabelsOfAnyKind(const ViewState& state) {
  return state.look.labels || !state.look.label_table.empty() || !state.look.label_looks.empty();
}
inline bool isAttenuated(const ViewState& state) {
  return state.look.mode == LookOptions::Mode::kAttenuatedMaximum;
}

}  // namespace sluice
