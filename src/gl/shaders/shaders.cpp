#include "src/gl/shaders/shaders.h"

#include <fmt/format.h>

#include <span>
#include <utility>
#include <vector>

#include "src/device/shading/rough_light.h"
#include "src/gl/box_buffer.h"
#include "src/gl/shaders/shader_text.h"

namespace sluice {
namespace {

constexpr const char* kVersion = "#version 330 core\n";

using Definitions = std::vector<std::pair<const char*, int>>;
Definitions numbersOf(const ShaderVariant& v) {
  return {{"COMBINING", static_cast<int>(v.combining)},
          {"PERSPECTIVE", v.perspective},
          {"LIT", v.lit},
          {"WITH_DEPTH", v.with_depth},
          {"STOPS_EARLY", v.stops_early},
          {"CLIP_PLANES", v.clip_planes},
          {"FLOATS", v.floats},
          {"COUNTS_TAKEN", v.counts_taken},
          {"GRADIENTS", v.lit || v.gradient_rows > 0},
          {"GRADIENT_ROWS", v.gradient_rows},
          {"FACTOR_TABLE", v.factor_table},
          {"CORRECTS", v.corrects},
          {"SHININESS", v.shininess},
          {"GOES_AHEAD", v.goes_ahead},
          {"LABELS", v.labels},
          {"LABEL_TABLE", v.label_table},
          {"PLANES", v.planes},
          {"CODES_DEPTH", v.codes_depth},
          {"SCALED", v.scaled},
          {"SPREAD", v.spread},
          {"SHARES", v.shares},
          {"INTEGRATES", v.integrates},
          {"SURFACES", v.surfaces},
          {"HAS_OPACITIES", v.has_opacities},
          {"FADES", v.fades},
          {"JOINED", v.joined},
          {"LIGHT_VOLUME", v.light_volume},
          {"CUES_DEPTH", v.cues_depth},
          {"JITTERS", v.jitters},
          {"OBLIQUE", v.oblique},
          {"FETCHES", v.fetches},
          {"ROUGH_FIRST", v.rough_first},
          {"KNOWS_VISIBLE", v.goes_ahead || v.rough_first}};
}
std::string definitions(const ShaderVariant& v) {
  std::string lines;
  for (const auto& [name, value] : numbersOf(v))
    lines += fmt::format("#define {} {}\n", name, value);
  // How often kSlopePart is in kSpreadPart, see rough_light.h.
  return lines +
         fmt::format("#define SLOPE_PARTS {:#.9g}\n", static_cast<float>(kSpreadPart / kSlopePart));
}

std::string undefined() {
  std::string lines = "#undef SLOPE_PARTS\n";
  for (const auto& [name, value] : numbersOf({})) lines += fmt::format("#undef {}\n", name);
  return lines;
}

// The names that a shader of several channels has once for each of them.
constexpr const char* kOfChannels[] = {
    "addSample",     "along",           "axis_cosines",     "box_hi",
    "box_lo",        "chunk",           "chunk_texel_size", "cornersAt",
    "cornersOf",     "corrected",       "differenceAt",     "Corners",
    "enterBox",      "entryColor",      "entryOf",          "shownColor",
    "entries",       "entry_offset",    "entry_scale",      "exactAt",
    "exactOf",       "factorOf",        "factors",          "filter_tie",
    "filteredAt",    "first",           "first_k",          "first_rows",
    "gradient_rows", "greatest",        "halfway0",         "halfway1",
    "index_halfway", "index_slope",     "index_toward",     "isNext",
    "labelAt",       "labelColor",      "labelEntry",       "label_entries",
    "least",         "look_up",         "neighbors",        "ramp",
    "range",         "readBox",         "reflection",       "roughAt",
    "shade",         "shine",           "shininess",        "slice_length",
    "slices",        "slope",           "squareOf",         "texel0",
    "texel_dx",      "texel_dy",        "texel_size",       "texelAt",
    "texelOf",       "textureOrder",    "toward0",          "toward1",
    "turn",          "view_reflection", "visible",          "visible_texels",
    "weightOf",      "labelSlopes",     "opacityAt",        "slopeWeights",
    "meanWeights",   "texel_scale",     "share_unit",       "expected",
    "expected_line", "expectedColor",   "spreadShareAt",    "expected_length",
    "sharedOpacity", "shownOf",         "soleBody",         "wideSlopes",
    "bodyOf",        "rough_parts",     "here_parts",       "even_light",
    "roughOf",       "mayShow",         "mayShowBetween",   "voxelLengths",
    "storedAt",      "WideSlopes",      "edge_parts",       "least_parts",
    "leastOf",       "greatestOf",      "texelLength"};
// Those of a box with surfaces, beyond these, that a shader has once for each box that joins one.
constexpr const char* kOfJoined[] = {
    "addMet",      "box_corner",   "crossing",       "endAt",         "fade_slope", "fade_start",
    "fadedAt",     "mayMeet",      "mayMeetIn",      "meetsLevel",    "partOf",     "place_origin",
    "sharedEndAt", "surfaceColor", "surface_colors", "surface_levels"};

// A text with the definitions of a variant and with names of its own.
std::string ownText(const ShaderVariant& variant, size_t number, const std::string& of) {
  std::string text = undefined(), after;
  text += definitions(variant) + "#undef TEXEL_SCALE\n#undef LABEL_ROW\n";
  for (const std::span<const char* const> names :
       {std::span<const char* const>(kOfChannels), std::span<const char* const>(kOfJoined)})
    for (const char* name : names) {
      text += fmt::format("#define {0} {0}_{1}\n", name, number);
      after += fmt::format("#undef {}\n", name);
    }
  return text + of + after;
}

// The text of one channel: the same as that of a single one, with names of its own.
std::string channelText(const ShaderVariant& variant, size_t channel) {
  return ownText(variant, channel,
                 std::string(kBoxInputsText) + kReadBoxText + kIntervalText + kWayText +
                     kTexelText + kColorText + kLabelText + kShownColorText + kChannelText);
}

// The texts of the boxes that join the variant's: nothing if none does. Behind them the variant's
// own definitions hold again.
std::string joinedText(const ShaderVariant& variant) {
  if (variant.joined == 0) return "";
  std::string text = fmt::format(
      "float met_part[{0}];\nvec4 met_color[{0}];\nint met_count;\n"
      "#undef FLAT\n#define FLAT\n",
      variant.surfaces * (1 + variant.joined));
  std::string enter, add, may = "false";
  for (int i = 0; i < variant.joined; ++i) {
    text += ownText(joinedVariant(variant, i), static_cast<size_t>(i),
                    std::string(kBoxInputsText) + kReadBoxText + kIntervalText + kWayText +
                        kTexelText + kColorText + kSurfaceText + kMetText + kJoinedText);
    enter +=
        fmt::format("readBox_{0}({1}); enterBox_{0}(pixel, ray); ", i, kTexelsPerBox * (i + 1));
    add +=
        fmt::format("for (bool met = mayMeetIn_{0}(k); met; met = false) addMet_{0}(k, ray); ", i);
    may += fmt::format(" || mayMeetIn_{}(k)", i);
  }
  text += undefined() + definitions(variant) + "#undef TEXEL_SCALE\n#define TEXEL_SCALE " +
          (variant.scaled ? "texel_scale\n" : "vec3(1.0)\n");
  return text + fmt::format(
                    "#define ENTER_JOINED {}\n#define ADD_JOINED {}\n"
                    "#define MAY_MEET_JOINED {}\n",
                    enter, add, may);
}

std::string placesText(const ShaderVariant& variant) {
  return variant.planes ? std::string(kPlanesText) + kPlaneSamplesText
                        : std::string(kIntervalText) + kWayText + kSliceSamplesText;
}

std::string samplesText(const ShaderVariant& variant) {
  if (variant.surfaces > 0)
    return std::string(kSurfaceText) + (variant.joined > 0 ? kMetText : "") + kSurfacesText;
  return variant.integrates ? kSegmentsText : kValuesText;
}

const char* combiningText(const ShaderVariant& variant) {
  if (variant.surfaces > 0) return "";  // part of the samples' text
  if (variant.codes_depth) return kDepthCodeText;
  switch (variant.combining) {
    case Combining::kBlend:
      return kBlendText;
    case Combining::kGreatest:
      return kGreatestText;
    case Combining::kLeast:
      return kLeastText;
    case Combining::kSum:
      return kAverageText;
    case Combining::kAttenuated:
      return kAttenuatedText;
  }
  return "";
}

std::string samplingText(const ShaderVariant& variant) {
  return std::string(kLightPlaceText) + kTexelText + kColorText + kLabelText + kShownColorText +
         kSumText + kSampleText + joinedText(variant) + samplesText(variant) +
         combiningText(variant) + kSampleMainText;
}

}  // namespace

ShaderVariant joinedVariant(const ShaderVariant& of, int number) {
  ShaderVariant variant = of;
  variant.joined = variant.joined_spreads = 0;
  variant.has_opacities = false;
  variant.fades = variant.scaled = true;
  variant.spread = (of.joined_spreads >> number & 1) != 0;
  variant.rough_first = false;
  return variant;
}

std::string vertexShader(const ShaderVariant& variant) {
  return kVersion + definitions(variant) + "#define FLAT flat out\n" + kViewInputsText +
         kBoxInputsText + kReadViewText + kReadBoxText + kVertexText;
}

std::string fragmentShader(const ShaderVariant& variant) {
  return kVersion + definitions(variant) + "#define FLAT flat in\n" + kViewInputsText +
         kBoxInputsText + kRayText + placesText(variant) +
         (variant.counts ? kCountText : samplingText(variant));
}

std::string blendedVertexShader(const BlendedVariant& variant) {
  return kVersion + definitions(variant.view) +
         fmt::format("#define CHANNELS {}\n#define FLAT flat out\n", variant.channels.size()) +
         kViewInputsText + kReadViewText + kBlendedVertexText;
}

std::string blendedFragmentShader(const BlendedVariant& variant) {
  std::string text = kVersion + definitions(variant.view) + "#define FLAT flat in\n" +
                     kViewInputsText + kRayText + kSumText + "#undef FLAT\n#define FLAT\n";
  std::string enter, add;
  for (size_t c = 0; c < variant.channels.size(); ++c) {
    text += channelText(variant.channels[c], c);
    enter += fmt::format(
        "readBox_{0}(block_at + {1}); enterBox_{0}(pixel, ray); "
        "all_slices = united(all_slices, range_{0}); ",
        c, kTexelsPerBox * (c + 1));
    add += fmt::format("addSample_{}(k, ray, total, clear); ", c);
  }
  return text + undefined() + definitions(variant.view) +
         fmt::format("#define ENTER_BOXES {}\n#define ADD_SAMPLES {}\n", enter, add) + kBlendedText;
}

}  // namespace sluice
