"""Fits of measured BSDFs beside Radiance's pabopto2bsdf, judged by truths that are known."""
