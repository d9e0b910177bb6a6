// All of the library: volumes larger than memory as pictures.
#pragma once

#include <sluice/array.h>
#include <sluice/error.h>
#include <sluice/image.h>
#include <sluice/options.h>
#include <sluice/progress.h>
#include <sluice/renderer.h>
#include <sluice/report.h>
#include <sluice/volume.h>
