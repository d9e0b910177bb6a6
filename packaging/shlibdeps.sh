#!/bin/sh
# dpkg-shlibdeps for CPack. Cairo draws annotations alone, and brings X11's libraries: the package
# recommends it.
exec dpkg-shlibdeps -xlibcairo2 "$@"
