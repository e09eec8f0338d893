import { effect, signal } from "@preact/signals";

export type Theme = "system" | "light" | "dark";

const KEY = "gridbloom.theme";

function stored(): Theme {
  try {
    const value = localStorage.getItem(KEY);
    return value === "light" || value === "dark" ? value : "system";
  } catch {
    return "system"; // storage may be forbidden; the page works without it
  }
}

/** The person's choice; "system" follows the device. */
export const theme = signal<Theme>(stored());

const deviceDark = matchMedia("(prefers-color-scheme: dark)");
const device = signal(deviceDark.matches);
deviceDark.addEventListener("change", () => {
  device.value = deviceDark.matches;
});

/** Whether the page is dark right now: what paints with token colours repaints when it changes. */
export const isDark = signal(false);

effect(() => {
  const choice = theme.value;
  if (choice === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = choice;
  isDark.value = choice === "system" ? device.value : choice === "dark";
  try {
    if (choice === "system") localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, choice);
  } catch {
    // as above
  }
});
