// Colours of temperatures. Lightness rises from cold to hot, so that the order shows in grey and to every kind of colour
// vision: points of viridis (S. van der Walt, N. Smith; CC0). The same in light and dark.
export const ramp = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

// Colours of numbers from `low` to `high`: css(value), and whether dark letters are readable on it.
export function colourScale(low, high) {
  const mix = value => {
    const at = (ramp.length - 1) * Math.min(1, Math.max(0, (value - low) / (high - low)));
    const i = Math.min(ramp.length - 2, Math.floor(at));
    return ramp[i].map((c, k) => Math.round(c + (at - i) * (ramp[i + 1][k] - c)));
  };
  return {
    low,
    high,
    css: value => `rgb(${mix(value).join(",")})`,
    darkLetters: value => {
      const [r, g, b] = mix(value);
      return 0.299 * r + 0.587 * g + 0.114 * b > 115;
    },
  };
}
