#!/usr/bin/env bash
# Draws the pictures of docs/gallery.md, each with the one command that the page shows, and writes the
# page; then docs/contact-sheet.png: every volume of DATA as `sluice render FILE -o x.png` alone shows it.
#   tools/gallery.sh [DATA [PROGRAM]]
# DATA: a folder with the volumes of the page (data); what is missing there is said, and its picture
# left as it is. PROGRAM: build/release/sluice otherwise. Needs oiiotool (openimageio-tools).
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
data=$(realpath "${1-data}")
sluice=$(realpath "${2-$root/build/release/sluice}")
command -v oiiotool >/dev/null || { echo "gallery.sh: oiiotool is missing; install openimageio-tools" >&2; exit 1; }
[[ -d $data ]] || { echo "gallery.sh: $data is no folder; name the one that holds the volumes" >&2; exit 1; }
docs=$root/docs
mkdir -p "$docs/gallery"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export SLUICE_INDEX_DIR=$work/index
mkdir "$work/data"
for file in "$data"/*; do
  [[ $file == *.sluice-index ]] || ln -s "$file" "$work/data/"
done
cd "$work"

page=$docs/gallery.md
side=300

# A picture without its alpha, over white, `side` pixels high and wide.
small() { # FROM TO SIDE
  oiiotool --nosoftwareattrib "$1" --resize "$3x$3" --create "$3x$3" 4 --fill:color=1,1,1,1 "$3x$3" --over \
    --ch R,G,B -d uint8 --compression jpeg:90 -o "$2"
}

# Whether all the files that a command reads are here.
have() {
  local word
  for word in $1; do
    word=${word//\'/}
    [[ $word != data/* ]] || compgen -G "${word//%03d/*}" >/dev/null || { echo "missing: $word" >&2; return 1; }
  done
}

picture() { # NAME CAPTION COMMAND
  local name=$1 caption=$2 line=$3
  printf '%s\n\n    %s\n\n![%s](gallery/%s.jpg)\n\n' "$caption" "$line" "$name" "$name" >>"$page"
  have "$line" || return 0
  eval "\"$sluice\"${line#sluice} -q"
  small "$name.png" "$docs/gallery/$name.jpg" "$side"
}

cat >"$page" <<'HEAD'
# Gallery

Above each picture is the command that draws it. `tools/gallery.sh DATA` draws all pictures again. DATA is a folder with
the volumes that the page of [data sets](../datasets.md) names. Volumes whose names begin with `synth:` need no file.
The exception is the first picture, `contact-sheet.png`: it shows every volume as `sluice render FILE -o x.png` draws it
without further options.

![Every volume without options](contact-sheet.png)

HEAD

picture bonsai 'CT of a bonsai, without any options' \
  'sluice render data/bonsai.nii.gz -o bonsai.png'
picture engine 'CT of an engine block, cut open, with axes, scale and colours' \
  'sluice render data/engine.nii.gz -o engine.png --crop 0,0,0,256,150,128 --map ct-bone --annotate'
picture head 'CT of a head, one TIFF file for each slice: the command gives the spacing and the up direction' \
  "sluice render 'data/cthead/%03d.tif' -o head.png --spacing 1,1,2 --up 0,0,-1 --azimuth 180 --elevation -10 --map ct-bone"
picture brain 'MRI of a head, cut at the level of the ears, from above' \
  'sluice render data/head-mr.nii.gz -o brain.png --crop 0,0,0,160,232,90 --elevation 35 --annotate'
picture activity 'A statistic of brain activity: the low and the high values, but none between them' \
  'sluice render data/motor-map.nii.gz -o activity.png --view top --annotate'
picture tooth 'CT of a tooth, standing on its crown' \
  'sluice render data/tooth/tooth.nhdr -o tooth.png --up 0,0,-1 --map ct-bone'
picture walnut 'A walnut cut open, without the tray it lies on' \
  'sluice render data/walnut_128x96x114_uint16.raw -o walnut.png --crop 0,24,0,128,96,57 --azimuth 150 --map viridis'
picture xray 'The head as in an X-ray picture: the mean value of each ray' \
  "sluice render 'data/cthead/%03d.tif' -o xray.png --spacing 1,1,2 --up 0,0,-1 --view left --mode average --range 20,140 --background 000000"
picture smoke 'Smoke from an OpenVDB file, in perspective' \
  'sluice render data/smoke.vdb -o smoke.png --projection perspective --background 202830'
picture fingers 'Salt that sinks through water, step 30 of a series' \
  "sluice render 'data/viscous-fingers/step_%03d.nrrd' -o fingers.png --time 30 --map inferno --up 0,0,1 --background 000000"
picture skull 'The skull as an opaque surface, under the skin as a translucent surface' \
  "sluice render 'data/cthead/%03d.tif' -o skull.png --spacing 1,1,2 --up 0,0,-1 --azimuth 215 --elevation -10 --iso '35:0.3:e0a080,95:1:f4efe2' --occlusion-light"
picture parts 'The engine block as a translucent surface, with its parts of another metal as an opaque one' \
  "sluice render data/engine.nii.gz -o parts.png --iso '90:0.25:9fb8cc,180:1:e0a030' --occlusion-light"
picture enamel 'The enamel of the tooth, and the pulp inside' \
  "sluice render data/tooth/tooth.nhdr -o enamel.png --up 0,0,-1 --iso '500:0.3:f2ead8,900:1:d8b070'"
picture shadows 'The bonsai in a light that casts shadows and does not reach far into pits' \
  'sluice render data/bonsai.nii.gz -o shadows.png --threshold 40 --opacity 0.6 --shadows --occlusion-light'
picture phantom 'The Shepp-Logan head, cut open' \
  'sluice render synth:phantom,dims=256x256x256 -o phantom.png --crop 0,0,0,256,128,256 --opacity 0.1'
picture labels 'The parts of the Shepp-Logan head as labels, bone and brain as a haze' \
  'sluice render synth:parts,dims=256x256x256 -o labels.png --labels --label 1=e8d8c0:0.02 --label 2=:0.004 --shade'
picture wave 'The Marschner-Lobb test signal: its values fill the whole range, so it is drawn as a solid block' \
  'sluice render synth:marschner-lobb,dims=128x128x128,type=f32 -o wave.png --up 0,0,1 --annotate'
picture rings 'Vortex rings in a flow' \
  'sluice render synth:flow,dims=160x160x160,type=f32 -o rings.png --map turbo --background 101418'
picture depths 'A bonsai: the greatest value of each ray, in the colour of its depth' \
  'sluice render data/bonsai.nii.gz -o depths.png --mode depth-mip --threshold 40 --map turbo --background 000000'

# The contact sheet.
tile=176
sheet=()
for file in data/*; do
  case $file in
    *.md | data/*.raw) [[ $file =~ _[0-9]+x[0-9]+x[0-9]+_ ]] || continue ;;
    data/cthead) file='data/cthead/%03d.tif' ;;
    data/viscous-fingers) file='data/viscous-fingers/step_%03d.nrrd' ;;
  esac
  if [[ -d $file && -z $(compgen -G "$file/*.png") ]]; then
    # A folder is one volume if it holds slices or a header.
    header=$(compgen -G "$file/*.n[rh][rd][dr]" | head -1) || continue
    file=$header
  fi
  label=${file#data/}
  label=${label%%/*}
  "$sluice" render "$file" -o tile.png --force -q
  small tile.png tile.jpg $tile
  oiiotool tile.jpg --create "${tile}x$((tile + 18))" 3 --fill:color=1,1,1 "${tile}x$((tile + 18))" --paste +0+0 \
    --text:x=$((tile / 2)):y=$((tile + 12)):size=11:font=DejaVuSans:color=0.1,0.1,0.1:xalign=center "${label/_[0-9]*x[0-9]*_*./.}" \
    -d uint8 -o "sheet_${#sheet[@]}.png"
  sheet+=("sheet_${#sheet[@]}.png")
done
columns=5
oiiotool --create "${tile}x$((tile + 18))" 3 --fill:color=1,1,1 "${tile}x$((tile + 18))" -d uint8 -o blank.png
while ((${#sheet[@]} % columns != 0)); do sheet+=(blank.png); done
oiiotool --nosoftwareattrib "${sheet[@]}" --mosaic:pad=2 "${columns}x$((${#sheet[@]} / columns))" -d uint8 \
  -o "$docs/contact-sheet.png"
echo "$page"
