// The parts of the window. Each draws itself from the state of the window and changes the state by
// the user's actions.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "src/view/window/window_state.h"

namespace sluice {

// The sections of the window's own panel, one below the other.
void lookPanel(WindowState& window);
void channelsPanel(WindowState& window);
void transferPanel(WindowState& window);
void surfacesPanel(WindowState& window);
void viewPanel(WindowState& window);
void cutPanel(WindowState& window);
void timePanel(WindowState& window);
void levelsPanel(WindowState& window);
void filmPanel(WindowState& window);
void filePanel(WindowState& window);

// A field that shows a colour. The word of the colour that the user chose there in this frame, if
// there is one.
std::optional<std::string> colorField(const std::array<double, 3>& rgb);

// The rest of it. Places in screen units.
struct Area {
  float x = 0, y = 0, width = 0, height = 0;
};
// `pixels`: of a screen unit.
void sidePanel(WindowState& window, const Area& area);
void picturePane(WindowState& window, const Area& area, float pixels);
void slicesPane(WindowState& window, const Area& area);
// Over the picture: the missing share, the value under the pointer, axes, scale and colours, and
// the handles of the clip box.
void drawOverlays(WindowState& window, const Area& area, float pixels);
// The face of the clip box whose handle is under the pointer: 2 * axis + (0: low, 1: high); -1:
// none.
int boxHandleAt(const WindowState& window, const Area& area, float pixels, float x, float y);
// Drags it by so many screen units.
void dragBoxHandle(WindowState& window, int face, float dx, float dy, float pixels);

// Draws the bars of the colours that the picture shows. Several channels have a row each.
void drawColorBars(WindowState& window, const Area& area);
// The left end of the bars with their words; the area's right end if there are none.
float colorBarsLeft(const WindowState& window, const Area& area);

// The place of a voxel in the world.
Vec3d worldOf(const WindowState& window, const std::array<double, 3>& voxel);
// `pixels`: pixels a screen unit, here and above.
void drawBoxHandles(WindowState& window, const Area& area, float pixels);

// Windows above the picture; each draws nothing unless it is open.
void helpWindow(WindowState& window);
void openWindow(WindowState& window);
void failuresWindow(WindowState& window);
// Handles the keyboard. To be called once a frame.
void takeKeys(WindowState& window);

}  // namespace sluice
