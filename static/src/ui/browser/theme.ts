import { effect, signal } from "@preact/signals";

type Theme = "system" | "light" | "dark";

const KEY = "gridbloom.theme";

function stored(): Theme {
  try {
    const value = localStorage.getItem(KEY);
    return value === "light" || value === "dark" ? value : "system";
  } catch {
    return "system"; // storage may be forbidden; the page works without it
  }
}

/** The visitor's choice; "system" follows the device. */
export const theme = signal<Theme>(stored());

const deviceDark = matchMedia("(prefers-color-scheme: dark)");
const device = signal(deviceDark.matches);
deviceDark.addEventListener("change", () => {
  device.value = deviceDark.matches;
});

/** Whether the page is being printed: always in light colours. */
export const printing = signal(false);
addEventListener("beforeprint", () => {
  printing.value = true;
});
addEventListener("afterprint", () => {
  printing.value = false;
});

/** Whether the page is dark now. Canvases are painted again when it changes. */
export const isDark = signal(false);

effect(() => {
  const shown = printing.value ? "light" : theme.value;
  if (shown === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = shown;
  isDark.value = shown === "system" ? device.value : shown === "dark";
});

effect(() => {
  const choice = theme.value;
  try {
    if (choice === "system") localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, choice);
  } catch {
    // as above
  }
});
