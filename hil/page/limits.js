// What limits are called, as in the summary of a run, by their keys in a picture.
export const LIMITS = {
  pulse: "pulse", burst: "burst", burst_energy: "burst energy", wire_power: "wire power, reserve", fingertip_power: "fingertip power, reserve", supply: "supply current",
  skin_mean: "skin at 0.1 mm, 10 s mean", skin_peak: "skin at 0.1 mm", skin_deep: "skin at 0.4 mm", omega: "Henriques dose", cem43: "dose, CEM43",
  displacement: "motor amplitude", "coil-heat": "coil, over the air", duty: "time on, of 10 s",
};
const OF_MOTORS = ["displacement", "coil-heat", "duty"];
// The limits of a bench.
export const limitsOf = ({ motors }) => Object.keys(LIMITS).filter(key => key === "burst" || OF_MOTORS.includes(key) === motors);
// The guard keeps a reserve of power for both windows; a summary has the mean over each.
const WINDOWS = { wire_power: ["wire power, 1 s", "wire power, 10 s"], fingertip_power: ["fingertip power, 1 s", "fingertip power, 60 s"] };
// What a summary measured of a limit; its rows come in the order of what was used.
export const measured = (key, rows) => rows.find(([name]) => (WINDOWS[key] ?? [LIMITS[key]]).includes(name))?.[1];
