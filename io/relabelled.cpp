#include "io/relabelled.h"

#include <utility>

#include "src/base/sources/forwarding_source.h"

namespace sluice {
namespace {

class RelabelledSource final : public ForwardingSource {
 public:
  RelabelledSource(std::unique_ptr<VolumeSource> source, VolumeLayout layout)
      : ForwardingSource(std::move(source)), layout_(std::move(layout)) {}
  const VolumeLayout& layout() const override { return layout_; }

 private:
  const VolumeLayout layout_;
};

}  // namespace

std::unique_ptr<VolumeSource> respaced(std::unique_ptr<VolumeSource> source,
                                       const std::optional<Vec3d>& spacing) {
  if (!spacing || *spacing == source->layout().spacing) return source;
  VolumeLayout layout = source->layout();
  layout.spacing = *spacing;
  return std::make_unique<RelabelledSource>(std::move(source), std::move(layout));
}

std::unique_ptr<VolumeSource> placedAt(std::unique_ptr<VolumeSource> source, Vec3d origin) {
  VolumeLayout layout = source->layout();
  layout.origin = origin;
  return std::make_unique<RelabelledSource>(std::move(source), std::move(layout));
}

std::unique_ptr<VolumeSource> withNote(std::unique_ptr<VolumeSource> source,
                                       const std::optional<std::string>& note) {
  if (!note) return source;
  VolumeLayout layout = source->layout();
  layout.notes.push_back(*note);
  return std::make_unique<RelabelledSource>(std::move(source), std::move(layout));
}

}  // namespace sluice
