// What remedies change, in Spanish.
import type { fixesEn } from './fixes.en';

export const fixesEs: Record<keyof typeof fixesEn, string> = {
  'fix.do': 'Arreglar: {change}',
  'fix.set-param': 'poner {label} a {value}',
  'fix.delete-item': 'borrar el punto {number}',
  'fix.add-takeoff': 'despegar primero, hasta {alt_m}',
  'fix.raise-takeoff': 'subir a {alt_m}',
  'fix.add-landing': 'aterrizar en casa, rumbo {course_deg}',
  'fix.turn-landing': 'aterrizar con rumbo {course_deg}',
  'fix.add-circle': 'subir o bajar antes en círculo a {alt_m}',
  'fix.raise': 'subirlo {difference_m}, y el punto anterior',
  'fix.move-away': 'alejarlo {distance_m}',
  'fix.set-parameter': 'poner {name} a {value} en el vehículo',
};
