import type { profileEn } from './profile.en';

export const profileEs: Record<keyof typeof profileEn, string> = {
  'profile.title': 'Lo vuela:',
  'profile.parameters': 'como dicen sus parámetros',
  'profile.flight': 'aprendido de su vuelo',
  'profile.recording': 'aprendido de una grabación…',
  'profile.file': 'Grabación de un vuelo (.tlog)',
  'profile.airframe.parameters': 'Un ala de espuma con hélice detrás, con lo que dicen los parámetros.',
  'profile.airframe.simulator': 'El avión del simulador de ArduPilot.',
  'profile.airframe.flight': 'El avión tal como lo mostró un vuelo, con {count} momentos.',
  'profile.too-short':
    'Su vuelo es demasiado corto para aprender de él: hacen falta uno o dos minutos en el aire, en más de un rumbo.',
  'battery.left': 'Batería al final: {left} ({energy} gastados).',
  'battery.none': 'La batería no llega: se agota a los {time}.',
  'battery.unknown': 'Batería al final: no se sabe. {why}',
  'battery.unknown.power': 'No se conoce la potencia del avión: apréndela de un vuelo.',
  'battery.unknown.capacity': 'No se conoce su capacidad.',
  'battery.unknown.voltage': 'No se conoce su tensión.',
  'odds.ask': 'Volarlo 200 veces',
  'odds.asking': 'Volándolo 200 veces con otros vientos…',
  'odds.cancel': 'Cancelar',
  'odds.hide': 'Ocultar las probabilidades',
  'odds.landed': '{part} aterrizan.',
  'odds.returned': '{part} vuelven y dan círculos.',
  'odds.unlimited': '{part} acaban en círculos sin fin.',
  'odds.endless': '{part} no acaban nunca.',
  'odds.ground': '{part} chocan con el suelo.',
  'odds.held': '{part} no avanzan contra el viento.',
  'odds.grounded': '{part} no despegan del suelo.',
  'odds.not-rehearsed': '{part} llegan a algo que no se ensaya.',
  'odds.too-long': '{part} siguen volando más de seis horas.',
  'odds.time': 'Nueve de cada diez tardan de {low} a {high}.',
  'odds.touch-down':
    'La mitad toca el suelo a menos de {median} de este lugar; diecinueve de cada veinte, a menos de {high}.',
  'odds.battery': 'Diecinueve de cada veinte dejan {low} de la batería o más; {count} de {runs}, menos que su reserva.',
  'odds.why':
    'Con vientos, rachas, empuje, resistencia y potencia algo distintos. Nueve de cada diez pasan por donde el mapa está sombreado.',
};
