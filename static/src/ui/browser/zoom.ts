/**
 * CSS pixels of the viewport per CSS pixel of an element: more than 1 where `zoom` enlarges it, as on slides. Pointers
 * and client rectangles are in pixels of the viewport; sizes and coordinates within the element are in its own.
 */
export const zoomOf = (element: Element): number =>
  (element as Element & { readonly currentCSSZoom?: number }).currentCSSZoom ?? 1;
