// The parts of the window. Each draws itself from the sitting and changes it by what the user does.
#pragma once

#include "src/view/window/sitting.h"

namespace sluice {

// In the window's own panel, one below the other.
void lookPanel(Sitting& sitting);
void transferPanel(Sitting& sitting);
void viewPanel(Sitting& sitting);
void cutPanel(Sitting& sitting);
void timePanel(Sitting& sitting);
void levelsPanel(Sitting& sitting);
void filmPanel(Sitting& sitting);
void filePanel(Sitting& sitting);

// The rest of it. Places in screen units.
struct Area {
  float x = 0, y = 0, width = 0, height = 0;
};
// `pixels`: of a screen unit.
void picturePane(Sitting& sitting, const Area& area, float pixels);
void slicesPane(Sitting& sitting, const Area& area);
// Over the picture: what is not complete, the value under the pointer, axes, scale and colours, and
// the handles of the clip box.
void drawOverlays(Sitting& sitting, const Area& area, float pixels);
// The face of the clip box whose handle is under the pointer: 2 * axis + (0: low, 1: high); -1:
// none.
int boxHandleAt(const Sitting& sitting, const Area& area, float pixels, float x, float y);
// Drags it by so many screen units.
void dragBoxHandle(Sitting& sitting, int face, float dx, float dy, float pixels);

void drawBoxHandles(Sitting& sitting, const Area& area, float pixels);

void helpWindow(Sitting& sitting);
void openWindow(Sitting& sitting);
void failuresWindow(Sitting& sitting);
// What keys do. Once a frame.
void takeKeys(Sitting& sitting);

}  // namespace sluice
