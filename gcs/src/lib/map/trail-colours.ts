// Height colours of trails from low to high, by brightness as well as hue, for dark and light maps.
export const TRAIL_COLOURS = {
  dark: ['#7a5fd0', '#5f7fe0', '#3f9fd8', '#2fb8b0', '#46cc7c', '#93d84a', '#d6de3a', '#ffe45c'],
  light: ['#440154', '#46327e', '#365c8d', '#277f8e', '#1a8f73', '#2f8a2f', '#8a7a00', '#b35900'],
} as const;
