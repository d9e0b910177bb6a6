#include "src/options/option_members.h"

#include "src/base/error.h"
#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"

namespace sluice {

OptionReals realsOf(const LookOptions::Opacity& point) {
  return {point.value, point.opacity};
}
OptionReals realsOf(const PictureOptions::Plane& plane) {
  return {plane.normal[0], plane.normal[1], plane.normal[2], plane.offset};
}
void assign(LookOptions::Opacity& point, const OptionReals& n) {
  point = {n[0], n[1]};
}
void assign(PictureOptions::Plane& plane, const OptionReals& n) {
  plane = {{n[0], n[1], n[2]}, n[3]};
}

// Channels, labels and surfaces are one text each in options and files, so that their own parsers
// remain the only ones.
std::string textOf(const LookOptions::Channel& channel) {
  ChannelLook look{.channel = channel.channel, .map = channel.map, .opacity = channel.opacity};
  if (channel.range) look.range = {(*channel.range)[0], (*channel.range)[1]};
  return channelLookText(look);
}
void assign(LookOptions::Channel& channel, const std::string& text) {
  // The rules of the option have refused any other text before it comes here.
  const std::optional<ChannelLook> look = parseChannelLook(text);
  SLUICE_CHECK(look.has_value());
  channel = {.channel = look->channel, .map = look->map, .opacity = look->opacity};
  if (look->range) channel.range = {look->range->lo, look->range->hi};
}

std::string textOf(const LookOptions::Label& label) {
  return labelLookText({label.first, label.last, label.color, label.opacity});
}
void assign(LookOptions::Label& label, const std::string& text) {
  const std::optional<LabelLook> look = parseLabelLook(text);
  SLUICE_CHECK(look.has_value());
  label = {look->first, look->last, look->color, look->opacity};
}

std::string textOf(const LookOptions::Surface& surface) {
  return surfaceLookText({surface.value, surface.opacity, surface.color});
}
void assign(LookOptions::Surface& surface, const std::string& text) {
  const std::optional<SurfaceLook> look = parseSurfaceLook(text);
  SLUICE_CHECK(look.has_value());
  surface = {look->value, look->opacity, look->color};
}

}  // namespace sluice
